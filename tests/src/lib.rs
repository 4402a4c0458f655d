//! What several tests of the pottery studio share.
