//! What goes into a session and what comes out of it: plain values that serialise.

mod command;
mod event;
mod facts;
mod offers;

pub use command::{Command, RunRequest, Spot, Value};
pub use event::Event;
pub use facts::{
    ChangeName, DoctorReport, File, FindingText, MeshSummary, NoticeText, PatternSize, PieceRow,
    RepairChoice, Row, Term, ToolParam, ToolSpec,
};
pub use offers::{
    Choice, Condition, MethodChoice, PaintChannel, ParamKind, ParamSpec, PresetChoice,
    SampleChoice, StageNumber, StageNumbers, SymmetryChoice, TradeChoice,
};
