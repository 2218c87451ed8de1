//! Picture tiles of the side-scan: a mean-and-max pyramid over ping and sample, built where it is looked at.
