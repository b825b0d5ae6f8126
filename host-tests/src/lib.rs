//! Bit-exactness regressions of slicecast.
