//! Code map.
