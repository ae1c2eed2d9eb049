// Meshes to open, and the reading of meshes that come back.

/** An ellipsoid of 10 · 4^level + 2 vertices: a subdivided icosahedron with half axes 1, 0.8 and 0.6. */
export function ellipsoid(level) {
  const golden = (1 + Math.sqrt(5)) / 2;
  const corners = [];
  for (const [a, b] of [[1, golden], [-1, golden], [1, -golden], [-1, -golden]]) {
    corners.push([0, a, b], [a, b, 0], [b, 0, a]);
  }
  // The faces are the triples of corners that are all one edge, of length 2, apart.
  const isEdge = (i, j) => Math.abs(Math.hypot(...corners[i].map((x, k) => x - corners[j][k])) - 2) < 1e-9;
  const points = corners.map(unit);
  let faces = [];
  for (let i = 0; i < 12; i += 1) {
    for (let j = i + 1; j < 12; j += 1) {
      for (let k = j + 1; k < 12; k += 1) {
        if (isEdge(i, j) && isEdge(j, k) && isEdge(k, i)) faces.push(outward(points, [i, j, k]));
      }
    }
  }
  for (let round = 0; round < level; round += 1) faces = subdivided(points, faces);
  const lines = points.map(([x, y, z]) => `v ${x.toFixed(6)} ${(0.8 * y).toFixed(6)} ${(0.6 * z).toFixed(6)}`);
  return [...lines, ...faces.map((face) => `f ${face.map((i) => i + 1).join(" ")}`), ""].join("\n");
}

const unit = (point) => point.map((x) => x / Math.hypot(...point));

function outward(points, [i, j, k]) {
  const [[a, b, c], [d, e, f], [g, h, l]] = [points[i], points[j], points[k]];
  const determinant = a * (e * l - f * h) - b * (d * l - f * g) + c * (d * h - e * g);
  return determinant > 0 ? [i, j, k] : [i, k, j];
}

/** Four faces for each one; the new points are added to `points`. */
function subdivided(points, faces) {
  const middles = new Map();
  const middle = (i, j) => {
    const key = i < j ? `${i} ${j}` : `${j} ${i}`;
    if (!middles.has(key)) middles.set(key, points.push(unit(points[i].map((x, k) => x + points[j][k]))) - 1);
    return middles.get(key);
  };
  return faces.flatMap(([a, b, c]) => {
    const [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    return [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]];
  });
}

/** `{ vertices, uvs, triangles }` of an OBJ; a triangle has `v` and `vt`, three 0-based indices each (`vt` may hold NaN). */
export function parseObj(text) {
  const mesh = { vertices: [], uvs: [], triangles: [] };
  for (const line of text.split("\n")) {
    const [key, ...words] = line.trim().split(/\s+/);
    if (key === "v") mesh.vertices.push(words.slice(0, 3).map(Number));
    if (key === "vt") mesh.uvs.push(words.slice(0, 2).map(Number));
    if (key !== "f") continue;
    const corners = words.map((word) => word.split("/").map((index) => (index ? Number(index) - 1 : NaN)));
    for (let i = 2; i < corners.length; i += 1) {
      const triangle = [corners[0], corners[i - 1], corners[i]];
      mesh.triangles.push({ v: triangle.map(([v]) => v), vt: triangle.map(([, vt = NaN]) => vt) });
    }
  }
  return mesh;
}

/** The area of all triangles in space. */
export function surfaceArea({ vertices, triangles }) {
  const area = ({ v }) => {
    const [a, b, c] = v.map((i) => vertices[i]);
    const [[x, y, z], [p, q, r]] = [b, c].map((point) => point.map((value, k) => value - a[k]));
    return Math.hypot(y * r - z * q, z * p - x * r, x * q - y * p) / 2;
  };
  return triangles.reduce((sum, triangle) => sum + area(triangle), 0);
}

/** The signed area of each triangle in the plane. */
export function uvAreas({ uvs, triangles }) {
  return triangles.map(({ vt }) => {
    const [[a, b], [c, d], [e, f]] = vt.map((i) => uvs[i]);
    return ((c - a) * (f - b) - (e - a) * (d - b)) / 2;
  });
}

/** Points and faces, 0-based, as an OBJ. */
export function asObj({ vertices, triangles }) {
  const lines = [...vertices.map((v) => `v ${v.join(" ")}`), ...triangles.map(({ v }) => `f ${v.map((i) => i + 1).join(" ")}`)];
  return `${lines.join("\n")}\n`;
}

/** The same mesh with every third face turned around. */
export const withFlippedFaces = (mesh) => ({
  ...mesh,
  triangles: mesh.triangles.map(({ v }, i) => ({ v: i % 3 === 0 ? v.toReversed() : v })),
});

/** The same mesh without two faces that share a vertex and no neighbour: the two holes touch in that vertex, a bow-tie. */
export function withTouchingHoles({ vertices, triangles }) {
  const shared = (one, other) => one.filter((i) => other.includes(i));
  const [{ v: first }] = triangles;
  const [apex] = first;
  const around = triangles.map(({ v }) => v).filter((v) => v.includes(apex) && v !== first);
  const isNeighbour = (one, other) => shared(one, other).length === 2;
  // On a vertex of five or six faces, one that is no neighbour of the first leaves a face on either side.
  const second = around.find((v) => !isNeighbour(v, first));
  return { vertices, triangles: triangles.filter(({ v }) => v !== first && v !== second) };
}

/** A binary STL: loose triangles, each with its own corners. */
export function asStl({ vertices, triangles }) {
  const bytes = Buffer.alloc(84 + 50 * triangles.length);
  bytes.writeUInt32LE(triangles.length, 80);
  triangles.forEach(({ v }, i) => {
    const numbers = [0, 0, 0, ...v.flatMap((k) => vertices[k])];
    numbers.forEach((x, k) => bytes.writeFloatLE(x, 84 + 50 * i + 4 * k));
  });
  return bytes;
}

/** A binary PLY, little-endian. */
export function asPly({ vertices, triangles }) {
  const header = [
    "ply",
    "format binary_little_endian 1.0",
    `element vertex ${vertices.length}`,
    ...["x", "y", "z"].map((name) => `property float ${name}`),
    `element face ${triangles.length}`,
    "property list uchar int vertex_indices",
    "end_header\n",
  ].join("\n");
  const faces = triangles.map(({ v }) => Buffer.concat([Buffer.from([3]), int32(v)]));
  return Buffer.concat([Buffer.from(header), float32(vertices.flat()), ...faces]);
}

/** An OFF. */
export function asOff({ vertices, triangles }) {
  const lines = ["OFF", `${vertices.length} ${triangles.length} 0`, ...vertices.map((v) => v.join(" "))];
  return [...lines, ...triangles.map(({ v }) => `3 ${v.join(" ")}`), ""].join("\n");
}

/** A GLB with one mesh of one primitive. */
export function asGlb({ vertices, triangles }) {
  const [points, indices] = [float32(vertices.flat()), int32(triangles.flatMap(({ v }) => v))];
  const bound = (pick) => [0, 1, 2].map((k) => Math.fround(pick(...vertices.map((v) => v[k]))));
  const json = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    buffers: [{ byteLength: points.length + indices.length }],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: points.length },
      { buffer: 0, byteOffset: points.length, byteLength: indices.length },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: vertices.length, type: "VEC3", min: bound(Math.min), max: bound(Math.max) },
      { bufferView: 1, componentType: 5125, count: 3 * triangles.length, type: "SCALAR" },
    ],
  };
  const text = JSON.stringify(json);
  const chunks = [
    chunk(0x4e4f534a, Buffer.from(text.padEnd(4 * Math.ceil(text.length / 4)))),
    chunk(0x004e4942, Buffer.concat([points, indices])),
  ];
  const size = 12 + chunks.reduce((sum, { length }) => sum + length, 0);
  return Buffer.concat([Buffer.from("glTF"), int32([2, size]), ...chunks]);
}

const chunk = (type, content) => Buffer.concat([int32([content.length, type]), content]);

function float32(numbers) {
  const bytes = Buffer.alloc(4 * numbers.length);
  numbers.forEach((x, i) => bytes.writeFloatLE(x, 4 * i));
  return bytes;
}

function int32(numbers) {
  const bytes = Buffer.alloc(4 * numbers.length);
  numbers.forEach((x, i) => bytes.writeInt32LE(x, 4 * i));
  return bytes;
}
