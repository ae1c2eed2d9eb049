// The presets on top of the parameters: one click sets several of them at once.

import { h, roving } from "../dom.js";

/** `apply(id)` sends one; `sampleLabel(name)` names the sample that a preset suits. */
export function presetsPanel(host, apply, sampleLabel) {
  const chips = h("div", { class: "chips" });
  const section = h("fieldset", { class: "presets", "aria-label": "Presets", hidden: true }, h("legend", {}, "Presets"), chips);
  host.replaceWith(section);
  // Arrows move the focus only: a preset may begin the cut anew.
  roving(chips, "button");
  let fingerprint = "";

  function chip({ id, label, help, sample }) {
    const suits = sample && sampleLabel(sample);
    const title = suits ? `${help} Made for the sample “${suits}”.` : help;
    return h("button", { type: "button", "data-id": id, "aria-pressed": "false", "aria-description": title, title, onclick: () => apply(id) }, label);
  }

  return {
    /** Takes a `presets` event. */
    show({ options, current }) {
      const print = JSON.stringify(options);
      if (print !== fingerprint) {
        fingerprint = print;
        chips.replaceChildren(...options.map(chip));
      }
      for (const button of chips.children) button.setAttribute("aria-pressed", String(button.dataset.id === current));
      section.hidden = options.length === 0;
    },
  };
}
