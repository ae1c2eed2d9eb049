// What the page says of a method where its own words differ.

export const METHODS = {
  cutflow: {
    label: "Cut flow",
    learn: "One step of the cut flow",
    sheet: { energy: "Energy", pieces: "Pieces" },
    empty: "uncut",
    hide: ["Hide seams from here", "Hide seams from here: makes cuts cost more wherever this view sees them"],
    hidden: ["penalty", "Cuts now cost more where this view sees them: the penalty η that is shown. Run moves them out of sight."],
  },
  cones: {
    label: "Cones",
    learn: "How the cones are found",
    sheet: { energy: "Distortion", pieces: "Cones" },
    empty: "unsolved",
    hide: ["Hide cones from here", "Hide cones from here: makes cones cost more wherever this view sees them"],
    hidden: ["cone_cost", "Cones now cost more where this view sees them: the cost that is shown."],
  },
  phasefield: {
    label: "Phase field",
    learn: "How a surface is divided by a phase field",
    sheet: { energy: "Energy", pieces: "Pieces" },
    empty: "undivided",
    hide: ["Hide seams from here", "Hide seams from here"],
    hidden: ["none", ""],
  },
  developable: {
    label: "Developable patches",
    learn: "How patches grow that nearly lie flat",
    sheet: { energy: "Seam", pieces: "Pieces" },
    plot: "Seam, √A",
    empty: "undivided",
    hide: ["Hide seams from here", "Hide seams from here: makes seams cost more wherever this view sees them"],
    hidden: ["penalty", "Seams now cost more where this view sees them. Reset and Run find others."],
  },
};
