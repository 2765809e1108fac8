//! Monocular visual odometry for first-person video: frames to path and sightings.
