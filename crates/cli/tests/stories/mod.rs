//! One story a claim.

mod bad_input;
mod bench;
mod eval;
mod georeference;
mod manners;
mod plan;
mod real_data;
mod results;
mod sim;
