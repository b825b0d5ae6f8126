//! Two-dimensional pre-integrated tables, as the paper has them, beside this library's integrals and beside samples.
//!
//! | file | what it holds |
//! |---|---|
//! | `function` | extinction and colour of codes, and their integral functions |
//! | `table` | tables: filling, updates, look-up, lengths |
//! | `cases` | fields and transfer functions |
//! | `figures` | errors along rays, and the times of filling |
//! | `curves` | errors against times of whole frames, by samples and by segments |
//! | `plot` | their picture |
//! | `pictures` | the paper's figures, remade |

pub mod cases;
pub mod curves;
pub mod figures;
pub mod function;
pub mod pictures;
pub mod plot;
pub mod table;
