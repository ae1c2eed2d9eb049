// Says in plain words what a browser lacks, before anything else is loaded. A classic script in old syntax: what it has to
// tell is for browsers that do not know the new one.

(function () {
  "use strict";

  /* The smallest module with an instruction on 128 bits. */
  var SIMD = [0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];

  function lacks() {
    var list = [];
    var hasWasm = typeof WebAssembly === "object" && typeof WebAssembly.validate === "function" && typeof Uint8Array === "function";
    if (!hasWasm) list.push("WebAssembly");
    else if (!WebAssembly.validate(new Uint8Array(SIMD))) list.push("WebAssembly with SIMD");
    if (typeof Worker !== "function") list.push("web workers");
    if (!("noModule" in document.createElement("script"))) list.push("JavaScript modules");
    return list;
  }

  function tell() {
    var list = lacks();
    var note = document.getElementById("unsupported");
    if (list.length === 0 || !note) return;
    var last = list.pop();
    var text = list.length > 0 ? list.join(", ") + " and " + last : last;
    note.getElementsByTagName("b")[0].textContent = "Cutflow does not run in this browser: it lacks " + text + ".";
    note.hidden = false;
    document.documentElement.setAttribute("data-unsupported", "");
  }

  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", tell);
  else tell();
})();
