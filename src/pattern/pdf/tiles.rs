//! Which part of the sheet is on which page.
//!
//! Windows of equal size overlap by a strip. In the middle of each strip lies the line where one page ends and the next one begins: so every
//! place of the sheet belongs to one page, and a page to which no ink belongs is not printed. Along that line two pages have the same marks.

use super::super::check::WriteError;
use super::super::labels::is_met;
use super::super::piece::{Bounds, piece_name};
use super::super::sheet::Sheet;
use super::ink::Ink;
use super::{Orientation, Paper, PdfParams};

/// Longest side of a page that readers take: 14400 points.
pub(super) const LONGEST: f64 = 5080.0;
/// Above each window, for what page it is.
pub(super) const BAND: f64 = 9.0;
/// Smallest window: the control square and a little more.
const SMALLEST: f64 = 60.0;
/// More pages than this nobody prints.
const MOST_PAGES: usize = 2000;
/// Free space around everything that is drawn: lines have a width.
const AROUND: f64 = 1.0;
/// Where the sheet lies between the first and the last page, as parts of the room that is left; the first that needs the
/// fewest pages.
const SHIFTS: [f64; 5] = [0.5, 0.0, 1.0, 0.25, 0.75];

/// A page of the sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Row as a letter from the top, column as a number: `B2`.
    pub name: String,
    /// Row, from the top.
    pub row: usize,
    /// Column.
    pub column: usize,
    /// Lower left corner of what it shows, on the sheet, mm.
    pub low: [f64; 2],
    /// Upper right corner.
    pub high: [f64; 2],
}

/// All pages, printed or not.
pub(super) struct Grid {
    /// Width and height of the paper.
    pub page: [f64; 2],
    /// Where windows lie on their page.
    pub window: Bounds,
    pub overlap: f64,
    pub columns: usize,
    pub rows: usize,
    /// Lower left corner of the lowest windows.
    low: [f64; 2],
    /// By row from the top, then by column.
    pub is_printed: Vec<bool>,
    /// Whether pages have frames, marks and bands: not if there is one page, the sheet itself.
    pub has_frame: bool,
    /// Whether pages are to be joined: not if each shows a sheet of stock of its own.
    pub is_joined: bool,
}

impl Grid {
    fn size(&self) -> [f64; 2] {
        [0, 1].map(|a| self.window.high[a] - self.window.low[a])
    }

    fn step(&self) -> [f64; 2] {
        self.size().map(|size| size - self.overlap)
    }

    /// What a page shows of the sheet.
    pub fn shown(&self, row: usize, column: usize) -> Bounds {
        let (size, step) = (self.size(), self.step());
        let from_below = (self.rows - 1 - row) as f64;
        let low = [self.low[0] + step[0] * column as f64, self.low[1] + step[1] * from_below];
        Bounds { low, high: [0, 1].map(|a| low[a] + size[a]) }
    }

    /// The part of that which belongs to no other page.
    pub fn own(&self, row: usize, column: usize) -> Bounds {
        let Bounds { mut low, mut high } = self.shown(row, column);
        let half = 0.5 * self.overlap;
        low[0] += if column > 0 { half } else { 0.0 };
        high[0] -= if column + 1 < self.columns { half } else { 0.0 };
        low[1] += if row + 1 < self.rows { half } else { 0.0 };
        high[1] -= if row > 0 { half } else { 0.0 };
        Bounds { low, high }
    }

    pub fn is_printed(&self, row: usize, column: usize) -> bool {
        row < self.rows && column < self.columns && self.is_printed[row * self.columns + column]
    }

    pub fn tiles(&self) -> Vec<Tile> {
        let cells = (0..self.rows).flat_map(|r| (0..self.columns).map(move |c| (r, c)));
        let printed = cells.filter(|&(row, column)| self.is_printed(row, column));
        let tile = |(row, column)| {
            let Bounds { low, high } = self.shown(row, column);
            let name = format!("{}{}", piece_name(row), column + 1);
            Tile { name, row, column, low, high }
        };
        printed.map(tile).collect()
    }

    /// Row and column of the page that a place belongs to.
    fn cell(&self, p: [f64; 2]) -> (usize, usize) {
        let step = self.step();
        let index = |a: usize, count: usize| {
            let i = ((p[a] - self.low[a] - 0.5 * self.overlap) / step[a]).floor();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
            let i = i.clamp(0.0, (count - 1) as f64) as usize;
            i
        };
        (self.rows - 1 - index(1, self.rows), index(0, self.columns))
    }

    /// Marks the pages to which ink belongs, or the inside of a piece.
    fn choose(&mut self, ink: &Ink, keep_inner: bool) {
        let mut is_printed = vec![false; self.rows * self.columns];
        let mut set = |row: usize, column: usize| is_printed[row * self.columns + column] = true;
        let around = |bounds: Bounds| Bounds {
            // What lies on the line between two pages belongs to both.
            low: bounds.low.map(|x| x - 1e-6),
            high: bounds.high.map(|x| x + 1e-6),
        };
        for polyline in &ink.polylines {
            let mut before: Option<([f64; 2], (usize, usize))> = None;
            for &b in polyline {
                let (s, d) = self.cell(b);
                if let Some((a, (r, c))) = before.replace((b, (s, d))) {
                    if (r, c) == (s, d) {
                        continue;
                    }
                    for row in r.min(s)..=r.max(s) {
                        for column in c.min(d)..=c.max(d) {
                            if is_met(&around(self.own(row, column)), a, b) {
                                set(row, column);
                            }
                        }
                    }
                }
                set(s, d);
            }
        }
        for bounds in &ink.boxes {
            let ((r, c), (s, d)) = (self.cell(bounds.low), self.cell(bounds.high));
            for row in s..=r {
                for column in c..=d {
                    set(row, column);
                }
            }
        }
        for row in (0..self.rows).filter(|_| keep_inner) {
            for column in 0..self.columns {
                let Bounds { low, high } = self.own(row, column);
                let middle = [0, 1].map(|a| 0.5 * (low[a] + high[a]));
                if !is_printed[row * self.columns + column] && ink.is_inside(middle) {
                    is_printed[row * self.columns + column] = true;
                }
            }
        }
        self.is_printed = is_printed;
    }

    fn count(&self) -> usize {
        self.is_printed.iter().filter(|&&is| is).count()
    }
}

/// The pages of a sheet: what each shows. Empty pages are left out.
///
/// **Fails** where margins and overlap leave no room on the page, and for thousands of pages.
pub fn tiles(sheet: &Sheet, params: &PdfParams) -> Result<Vec<Tile>, WriteError> {
    Ok(grid(sheet, params)?.tiles())
}

/// A page for each sheet of stock, where one fits on a page.
fn by_stock(sheet: &Sheet, params: &PdfParams) -> Option<Grid> {
    let first = sheet.frames.first()?;
    let size = |frame: &Bounds| [0, 1].map(|a| frame.high[a] - frame.low[a]);
    let [width, height] = size(first);
    let is_like = |frame: &Bounds| {
        let [w, h] = size(frame);
        (w - width).abs() < 1e-6 && (h - height).abs() < 1e-6
    };
    // From one to the next: they stand side by side.
    let step = sheet.frames.get(1).map_or(0.0, |second| second.low[0] - first.low[0]);
    let margin = params.margin_mm;
    let furniture = [2.0 * margin, 2.0 * margin + BAND];
    let upright = params.paper.size([width, height], furniture);
    let pages = params.orientation.pages(params.paper, upright, [width, height], furniture);
    let fits = |page: &[f64; 2]| {
        page[0] - furniture[0] >= width - 1e-6 && page[1] - furniture[1] >= height - 1e-6
    };
    let page = pages.into_iter().find(fits)?;
    let columns = sheet.frames.len();
    (sheet.frames.iter().all(is_like) && columns <= MOST_PAGES).then(|| {
        let window = Bounds { low: [margin; 2], high: [page[0] - margin, page[1] - margin - BAND] };
        let room = size(&window);
        Grid {
            page,
            window,
            overlap: if columns > 1 { room[0] - step } else { 0.0 },
            columns,
            rows: 1,
            low: [first.low[0] - 0.5 * (room[0] - width), first.low[1] - 0.5 * (room[1] - height)],
            is_printed: vec![true; columns],
            has_frame: true,
            is_joined: false,
        }
    })
}

pub(super) fn grid(sheet: &Sheet, params: &PdfParams) -> Result<Grid, WriteError> {
    super::super::check::refuse(sheet)?;
    if params.paper == Paper::OnePage && sheet.size.iter().all(|&x| x <= LONGEST) {
        return Ok(Grid {
            page: sheet.size,
            window: Bounds { low: [0.0; 2], high: sheet.size },
            overlap: 0.0,
            columns: 1,
            rows: 1,
            low: [0.0; 2],
            is_printed: vec![true],
            has_frame: false,
            is_joined: false,
        });
    }
    if let Some(grid) = by_stock(sheet, params) {
        return Ok(grid);
    }
    let ink = Ink::new(sheet, &params.layers, false);
    let low = ink.bounds.low.map(|x| x - AROUND);
    let extent = [0, 1].map(|a| ink.bounds.high[a] + AROUND - low[a]);
    let (margin, overlap) = (params.margin_mm, params.overlap_mm);
    let furniture = [2.0 * margin, 2.0 * margin + BAND];
    let is_sane = |x: f64| (0.0..LONGEST).contains(&x);
    let upright = params.paper.size(extent, furniture);
    let mut best: Option<(usize, Grid)> = None;
    for page in params.orientation.pages(params.paper, upright, extent, furniture) {
        let size = [0, 1].map(|a| page[a] - furniture[a]);
        let step = size.map(|size| size - overlap);
        let is_roomy = step.iter().all(|&step| step >= SMALLEST - 1e-9);
        if !(is_sane(margin) && is_sane(overlap) && is_roomy) {
            return Err(WriteError::NoRoom { window: step });
        }
        // As many windows as cover everything; a hair's breadth is no page.
        let counts = [0, 1].map(|a| ((extent[a] - overlap) / step[a] - 1e-9).ceil().max(1.0));
        let pages = counts[0] * counts[1];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded")]
        let [columns, rows] = counts.map(|x| x.min(1e6) as usize);
        if pages > (8 * MOST_PAGES) as f64 {
            return Err(WriteError::TooManyPages { pages: columns * rows, limit: MOST_PAGES });
        }
        let slack = [0, 1].map(|a| counts[a] * step[a] + overlap - extent[a]);
        for [x, y] in SHIFTS.iter().flat_map(|&y| SHIFTS.map(|x| [x, y])) {
            let mut grid = Grid {
                page,
                window: Bounds {
                    low: [margin; 2],
                    high: [page[0] - margin, page[1] - margin - BAND],
                },
                overlap,
                columns,
                rows,
                low: [low[0] - x * slack[0], low[1] - y * slack[1]],
                is_printed: Vec::new(),
                has_frame: true,
                is_joined: true,
            };
            grid.choose(&ink, params.keep_inner_pages);
            let count = grid.count();
            if best.as_ref().is_none_or(|(fewest, _)| count < *fewest) {
                best = Some((count, grid));
            }
            if pages <= 1.0 {
                break;
            }
        }
    }
    match best {
        Some((pages, _)) if pages > MOST_PAGES => {
            Err(WriteError::TooManyPages { pages, limit: MOST_PAGES })
        }
        Some((_, grid)) => Ok(grid),
        None => Err(WriteError::NoRoom { window: upright }),
    }
}

impl Paper {
    /// Width and height of a sheet of office paper, upright.
    pub(super) fn upright(self) -> [f64; 2] {
        self.size([0.0; 2], [0.0; 2])
    }

    /// Width and height, upright; of a roll and of one page as long as they need to be, and no longer than readers take.
    fn size(self, extent: [f64; 2], furniture: [f64; 2]) -> [f64; 2] {
        let along = |a: usize| (extent[a] + furniture[a]).min(LONGEST);
        match self {
            Self::A4 => [210.0, 297.0],
            Self::A3 => [297.0, 420.0],
            Self::Letter => [215.9, 279.4],
            Self::Legal => [215.9, 355.6],
            Self::Tabloid => [279.4, 431.8],
            Self::OnePage => [along(0), along(1)],
            Self::Roll { width_mm } => [width_mm, along(1)],
        }
    }
}

impl Orientation {
    /// Pages to try.
    fn pages(
        self,
        paper: Paper,
        upright: [f64; 2],
        extent: [f64; 2],
        furniture: [f64; 2],
    ) -> Vec<[f64; 2]> {
        let lying = match paper {
            Paper::OnePage => return vec![upright],
            Paper::Roll { width_mm } => [(extent[0] + furniture[0]).min(LONGEST), width_mm],
            _ => [upright[1], upright[0]],
        };
        match self {
            Self::Auto => vec![upright, lying],
            Self::Portrait => vec![upright],
            Self::Landscape => vec![lying],
        }
    }
}
