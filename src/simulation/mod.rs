//! Simulated surveys of known truth, written as valid SL2.
