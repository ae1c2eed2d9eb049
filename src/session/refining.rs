//! Evening out (comes with the flow).

use super::layout::Layout;
use super::surface::Surface;
use super::text::Problem;

pub struct Refinement;
impl Refinement {
    pub fn begin(_: &Surface, _: &Layout, _: &str, _: &[f64]) -> Result<Option<Self>, Problem> {
        Ok(None)
    }
    pub fn finish(&mut self, _: &Surface, _: &mut Layout) -> Result<(), Problem> {
        Ok(())
    }
}
