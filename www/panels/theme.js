// Dark and light: follows the system until a person says otherwise, and again when both agree.

import { byId } from "../dom.js";
import { recall, remember } from "../storage.js";

/** The name of the choice in the storage. */
const KEY = "theme";

/** `changed(dark)` is called at once and after every change. */
export function theme(changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const button = byId("theme");
  let choice = recall(KEY);

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
    remember(KEY, choice);
    apply();
  });
  system.addEventListener("change", apply);
  apply();
}
