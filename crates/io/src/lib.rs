//! Videos, floor plans, cameras and trajectories read from and written to files.
