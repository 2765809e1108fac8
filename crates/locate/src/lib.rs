//! Localisation of a path and its sightings on a floor plan.
