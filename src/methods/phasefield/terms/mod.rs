//! The terms of the objective one by one, each with its exact gradient.

pub(super) mod area;
pub(super) mod connected;
pub(super) mod perimeter;
pub(super) mod sharp;
pub(super) mod yamabe;
