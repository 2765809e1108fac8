//! Simulated buildings, walkers and cameras with known truth.
