//! What a document is, as a number: how it is told that Undo, Redo and refusals leave nothing behind.

use std::fmt::{self, Write};

use super::Session;
use super::params::Settings;
use crate::mesh::Soup;

/// FNV-1a (Fowler, Noll, Vo) over what is written to it.
struct Fnv(u64);

impl Write for Fnv {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(())
    }
}

impl Session {
    /// A number that documents share only if mesh, method, parameters, paint, cut, cones, segments and allowances are the same to the last bit.
    ///
    /// **Means** nothing from one version to the next. What is only shown and what runs do not count.
    pub fn digest(&self) -> u64 {
        let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
        // Writing to a number cannot fail.
        let _ = self.describe(&mut hash);
        hash.0
    }

    /// The parts that [`Session::digest`] is made of, by name: what differs is found by comparing them.
    pub fn digests(&self) -> Vec<(&'static str, u64)> {
        let parts: [(&'static str, Part); 8] = [
            ("mesh", Self::describe_mesh),
            ("settings", Self::describe_settings),
            ("layers", Self::describe_layers),
            ("flow", Self::describe_flow),
            ("cones", Self::describe_cones),
            ("segments", Self::describe_segments),
            ("history", Self::describe_history),
            ("seams", Self::describe_seams),
        ];
        let digest = |(name, part): (&'static str, Part)| {
            let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
            let _ = part(self, &mut hash);
            (name, hash.0)
        };
        parts.into_iter().map(digest).collect()
    }

    /// Values of all parameters of the open document.
    pub fn settings(&self) -> Option<&Settings> {
        self.work.as_ref().map(|work| &work.settings)
    }

    /// How many changes Undo can take back.
    pub fn undo_depth(&self) -> usize {
        self.undo.len()
    }

    fn describe(&self, to: &mut dyn Write) -> fmt::Result {
        self.digests().iter().try_for_each(|(_, digest)| write!(to, "{digest} "))
    }

    fn describe_mesh(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        let document = &work.document;
        // The lines of a file are no part of its mesh: a project has others.
        let soup = Soup { lines: Vec::new(), ..(*document.soup).clone() };
        write!(to, "{} {} {soup:?}", document.name, document.format)
    }

    fn describe_settings(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        write!(to, "{:?} {:?}", work.method, work.settings)
    }

    fn describe_layers(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        write!(to, "{:?}", work.layers)
    }

    fn describe_flow(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        let checkpoint = work.flow.as_ref().map(|flow| flow.checkpoint());
        write!(to, "{:?} {checkpoint:?}", work.first_cut_is_due)
    }

    fn describe_cones(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        write!(to, "{:?}", work.cones.edits)
    }

    fn describe_segments(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        if let Some(checkpoint) = work.phase.checkpoint() {
            checkpoint.describe(to)?;
        }
        if let Some(checkpoint) = work.develop.checkpoint() {
            checkpoint.describe(to)?;
        }
        Ok(())
    }

    fn describe_history(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        write!(to, "{:?}", work.history)
    }

    fn describe_seams(&self, to: &mut dyn Write) -> fmt::Result {
        let Some(work) = &self.work else { return Ok(()) };
        write!(to, "{:?}", work.seam_allowances)
    }
}

type Part = fn(&Session, &mut dyn Write) -> fmt::Result;
