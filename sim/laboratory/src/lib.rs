//! The precision laboratory: formats that the library does not ship, run through the very same pipeline.
//!
//! The widths of a study are values, so that all studies are one pipeline; core's stages read them as they read the
//! constants of a shipped precision. Nothing here is linked by firmware, and no stage is written a second time.
//!
//! | file | what it holds |
//! |---|---|
//! | `channels` | accumulator formats, 1 to 31 bits |
//! | `pixels` | compositing: products, telescoping, residual carry, the [0, 255] scale |
//! | `codes` | opacity in a table entry: plain or as a root, 8 or 16 bits |
//! | `formats` | the precision of a study |
//! | `parameters` | what a configuration is made of, for reports and for `--vary` |
//! | `catalogue` | the configurations of a sweep, and those of any width |
//! | `measure` | errors and speed of one configuration |
//! | `choose` | which of them a sweep runs |
//! | `sweep` | their errors and speeds, batch by batch |
//! | `shards` | parts of a sweep, and the table of all |
//! | `rows` | the file of finished rows |
//! | `ensemble` | one configuration against another over many views |
//! | `pareto` | which configurations nothing beats |
//! | `hard` | the hard cases |
//! | `borders` | the ends of rays after LaMar, whole steps beside exact ones: figures and cost |
//! | `clock` | times of one processor |
//! | `reflectance` | reflectance maps by their size, beside Phong |
//! | `splats` | splatting by the widths of its records, beside rays |
//! | `segments` | two-dimensional pre-integrated tables beside the integrals |
//! | `texture` | texture hardware of 8 bits, as a comparator; figure 1 and teaser of Squeeze |

pub mod borders;
pub mod catalogue;
pub mod channels;
pub mod choose;
mod clock;
pub mod codes;
pub mod ensemble;
pub mod formats;
pub mod hard;
pub mod measure;
pub mod parameters;
pub mod pareto;
pub mod pixels;
pub mod reflectance;
pub mod report;
pub mod rows;
pub mod segments;
pub mod shards;
pub mod splats;
pub mod sweep;
pub mod texture;
