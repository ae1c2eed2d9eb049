// Keys: letters work wherever nothing is being typed, Space and Enter belong to the control in focus.

/**
 * @param on `actions` by key; `press(id)` presses a button of the page; `dismiss()` takes an error away, `held(key)` is
 * asked what the key means to the tool in hand: both give whether there was anything to do
 */
export function listenToKeys({ actions, press, dismiss, held }) {
  addEventListener("keydown", (event) => {
    // Some keyboards reach a bracket with Alt.
    const isBracket = event.key === "[" || event.key === "]";
    if (event.defaultPrevented || (event.altKey && !isBracket)) return;
    const { target } = event;
    const types = target.matches("select, textarea, input:not([type=range], [type=checkbox], [type=file])");
    if (!isBracket && (event.ctrlKey || event.metaKey)) {
      if (event.key.toLowerCase() !== "z" || types) return;
      event.preventDefault();
      press(event.shiftKey ? "redo" : "undo");
      return;
    }
    if (event.key === "Escape" && dismiss()) return;
    // Digits go by their place: with Shift, and on some keyboards without, they write something else.
    const digit = /^(?:Digit|Numpad)(\d)$/.exec(event.code)?.[1];
    const typed = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const name = digit && digitsMean(event.key, digit) ? `${event.shiftKey ? "Shift " : ""}${digit}` : typed;
    if (types && !(name === "Escape" && target.matches("select"))) return;
    if (held(name)) {
      event.preventDefault();
      return;
    }
    const isControl = target.closest("button, a, input, summary, select, [role=menu]") !== null;
    if (!actions[name] || (event.key === " " && isControl)) return;
    event.preventDefault();
    actions[name]();
  });
}

/** Whether a key of the row of digits stands for its digit: keys of other signs on it that mean something keep their meaning. */
const digitsMean = (key, digit) => key === digit || !"[].?".includes(key);
