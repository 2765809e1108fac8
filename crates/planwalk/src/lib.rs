//! Where on a floor plan was a first-person video walked?.
