//! One file a claim that is more than a picture's.

mod eval_pictures;
mod evo;
