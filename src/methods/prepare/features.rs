//! Lines that must stay.
