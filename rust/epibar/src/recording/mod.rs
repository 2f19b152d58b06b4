//! One camera over time.
