//! One story a claim.

mod bad_input;
mod real_data;
mod results;
