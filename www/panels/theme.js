// Dark and light: follows the system until a person says otherwise, and again when both agree.

import { byId } from "../dom.js";

const KEY = "cutflow.theme";

function recall() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    // Private windows and embedded pages may have no storage; the choice then lasts as long as the page.
    return null;
  }
}

function remember(choice) {
  try {
    if (choice) localStorage.setItem(KEY, choice);
    else localStorage.removeItem(KEY);
  } catch {
    // See above.
  }
}

/** `changed(dark)` is called at once and after every change. */
export function theme(changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const button = byId("theme");
  let choice = recall();

  const isDark = () => (choice ? choice === "dark" : system.matches);
  function apply() {
    if (choice) document.documentElement.dataset.theme = choice;
    else delete document.documentElement.dataset.theme;
    button.title = `${isDark() ? "Dark" : "Light"}${choice ? "" : ", as the system"}: change to ${isDark() ? "light" : "dark"}`;
    changed(isDark());
  }
  button.addEventListener("click", () => {
    const wanted = isDark() ? "light" : "dark";
    choice = (wanted === "dark") === system.matches ? null : wanted;
    remember(choice);
    apply();
  });
  system.addEventListener("change", apply);
  apply();
}
