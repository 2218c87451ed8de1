//! Files that other programs open: CSV, PLY, LAZ; written aside, then renamed.
