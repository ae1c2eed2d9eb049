// Files come through the file input, or are dropped anywhere on the page.

import { byId } from "../dom.js";

/** What a mesh file is called. Its content decides; the name only tells which one of several is meant. */
const MESH_NAME = /\.(obj|ply|stl|off|glb|gltf)$/i;

/** `{ file, left }`: the first mesh among several files, and how many are left out. */
function choose(files) {
  const file = files.find(({ name }) => MESH_NAME.test(name)) ?? files[0];
  return { file, left: files.length - 1 };
}

/** `open(file, left)` is called with a file, and with the number of others that came with it. */
export function fileSources(open) {
  byId("file").addEventListener("change", ({ target }) => {
    const [file] = target.files;
    // The same file may be chosen again after it was changed.
    target.value = "";
    if (file) open(file, 0);
  });

  const zone = byId("drop");
  const holdsFiles = (event) => event.dataTransfer?.types.includes("Files");
  addEventListener("dragenter", (event) => {
    if (holdsFiles(event)) zone.hidden = false;
  });
  addEventListener("dragover", (event) => {
    if (!holdsFiles(event)) return;
    event.preventDefault();
    event.dataTransfer.dropEffect = "copy";
    zone.hidden = false;
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) zone.hidden = true;
  });
  addEventListener("drop", (event) => {
    zone.hidden = true;
    if (!holdsFiles(event)) return;
    event.preventDefault();
    const { file, left } = choose([...event.dataTransfer.files]);
    if (file) open(file, left);
  });
}
