"""Mesh files: OBJ by its tokens, all of them by trimesh."""

import json
import struct

import numpy
import trimesh

# Single precision of numbers up to 1.
SINGLE = 1e-7


def model_of(path):
    model = path.with_name("model.json")
    return json.loads(model.read_text()) if model.exists() else None


class Obj:
    """An OBJ as tokens: nothing merged, nothing renumbered."""

    def __init__(self, path):
        self.lines = path.read_bytes().decode("utf-8").split("\n")
        tokens = [line.split() for line in self.lines]
        self.position_lines = [line for line in self.lines if line.startswith("v ")]
        self.v = numpy.array([[float(x) for x in t[1:]] for t in tokens if t[:1] == ["v"]])
        self.vt = numpy.array([[float(x) for x in t[1:]] for t in tokens if t[:1] == ["vt"]])
        self.corners = [[c.split("/") for c in t[1:]] for t in tokens if t[:1] == ["f"]]
        self.polylines = [[int(x) for x in t[1:]] for t in tokens if t[:1] == ["l"]]
        self.groups = [t[1:] for t in tokens if t[:1] == ["g"]]
        self.materials = [line.split(None, 1)[1] for line in self.lines if line.startswith("usemtl ")]

    def faces(self, part):
        return numpy.array([[int(c[part]) - 1 for c in face] for face in self.corners])

    def pieces(self):
        """The piece of every face, from 1, by the names of the groups."""
        piece, pieces = None, []
        for line in self.lines:
            words = line.split()
            if words[:1] == ["g"]:
                piece = int(words[1].removeprefix("piece_"))
            if words[:1] == ["f"]:
                pieces.append(piece)
        return numpy.array(pieces)


def areas(points, faces):
    a, b, c = (points[faces[:, i]] for i in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def rows(array):
    """Rows in an order of their own, to compare sets."""
    return array[numpy.lexsort(array.T[::-1])]


def check_input(path, hold):
    hold(len(Obj(path).v) > 0, "the input has vertices")


def check_any_obj(path, hold):
    mesh = trimesh.load(path, process=False, force="mesh")
    hold(len(mesh.faces) > 0, "trimesh reads faces")


def check_uv_obj(path, hold):
    obj = Obj(path)
    hold(numpy.isfinite(obj.v).all() and numpy.isfinite(obj.vt).all(), "all numbers are finite")
    v, vt = obj.faces(0), obj.faces(1)
    hold(v.shape[1] == 3 and v.min() >= 0 and v.max() < len(obj.v), "faces are triangles of vertices that exist")
    hold(vt.min() >= 0 and vt.max() < len(obj.vt), "every corner has a place in the map that exists")
    hold(len(numpy.unique(vt)) == len(obj.vt), "no place in the map goes unused")
    hold(0 <= obj.vt.min() and obj.vt.max() == 1, "the map fills the unit square")
    hold((areas(obj.vt, vt) > 0).all(), "no triangle of the map is turned over")
    mesh = trimesh.load(path, process=False, maintain_order=True, force="mesh")
    wanted = obj.v[v][numpy.argsort(obj.pieces(), kind="stable")]
    hold(same_triangles(mesh.triangles, wanted, 1e-12), "trimesh reads the same triangles, in their order or by material")
    input_path = path.with_name("input.obj")
    if not input_path.exists():
        return
    given, model = Obj(input_path), model_of(path)
    count = len(given.v)
    hold(numpy.array_equal(obj.v[:count], given.v), "the input's vertices come first, equal to the last bit")
    if "Cutflow" in given.lines[0]:
        # Numbers in the shortest form, as we write them: others may be longer and mean the same.
        hold(obj.position_lines[:count] == given.position_lines, "lines of vertices are those of the input, byte for byte")
    else:
        normals = [line for line in obj.lines if line.startswith("vn ")]
        own = [line for line in given.lines if line.startswith("vn ")]
        hold(normals[: len(own)] == own, "the input's normals come first, byte for byte")
        hold(set(obj.materials) == set(given.materials), "materials keep their names")
        names = {"_".join(g) for g in given.groups}
        hold({g[1] for g in obj.groups} == names, "groups keep their names, as one word")
    hold(len(obj.v) == count + model["new_points"], "new vertices follow, and no others")
    hold(len(obj.corners) == model["triangles"], "all triangles are there")
    hold(sorted(obj.pieces()) == sorted(model["face_pieces"]), "groups are the pieces")
    hold(corner_map_is_split_at_seams_only(v, vt), "a vertex has one place in the map on each side of a seam")


def corner_map_is_split_at_seams_only(v, vt):
    """Places in the map belong to one vertex each."""
    pairs = numpy.unique(numpy.stack([vt.ravel(), v.ravel()], axis=1), axis=0)
    return len(pairs) == len(numpy.unique(vt))


def same_triangles(a, b, tolerance):
    """Equal, or equal in another order of faces."""
    a, b = a.reshape(-1, 9), b.reshape(-1, 9)
    if a.shape != b.shape:
        return False
    return bool(numpy.allclose(a, b, rtol=0, atol=tolerance) or numpy.allclose(rows(a.round(9)), rows(b.round(9)), rtol=0, atol=tolerance + 1e-9))


def check_flat_obj(path, hold):
    flat, uv = Obj(path), Obj(path.with_name("uv.obj"))
    hold((flat.v[:, 2] == 0).all() and flat.v.min() == 0, "all vertices lie in the plane, from 0")
    faces = flat.faces(0)
    hold((areas(flat.v[:, :2], faces) > 0).all(), "no triangle is turned over")
    hold(numpy.array_equal(faces, uv.faces(1)), "faces are those of the map")
    side = next(float(line.split()[2]) for line in flat.lines if line.startswith("# uv_scale_mm"))
    hold(numpy.allclose(flat.v[:, :2], uv.vt * side, rtol=0, atol=1e-9 * side), "the stated side of the unit square makes millimetres of the map")
    model = model_of(path)
    mesh = trimesh.load(path, process=False, force="mesh")
    hold(len(mesh.faces) == model["triangles"], "trimesh reads all triangles")
    if model["is_developable"]:
        solid = uv.v[uv.faces(0)] * model["mm_per_unit"]
        on_surface = 0.5 * numpy.linalg.norm(numpy.cross(solid[:, 1] - solid[:, 0], solid[:, 2] - solid[:, 0]), axis=1)
        hold(numpy.allclose(areas(flat.v[:, :2], faces), on_surface, rtol=1e-6), "each triangle is as large as on the surface, in mm²")


def check_cut_obj(path, hold):
    obj = Obj(path)
    hold(len(obj.polylines) > 0, "there are polylines")
    used = {i for line in obj.polylines for i in line}
    hold(used == set(range(1, len(obj.v) + 1)), "they use every point")
    uv = Obj(path.with_name("uv.obj")).v
    known = {tuple(p) for p in uv}
    hold(all(tuple(p) in known for p in obj.v), "points of the cut are vertices of the cut surface, to the last bit")


def check_ply(path, hold):
    model, obj = model_of(path), Obj(path.with_name("uv.obj"))
    mesh = trimesh.load(path, process=False)
    count = model["input_vertices"]
    vertex = mesh.metadata["_ply_raw"]["vertex"]["data"]
    face = mesh.metadata["_ply_raw"]["face"]["data"]
    source = vertex["source_vertex"].ravel()
    hold(numpy.array_equal(mesh.vertices, obj.v[source]), f"trimesh reads vertices equal to the last bit to those that they came from ({count} of the input)")
    hold(len(mesh.faces) == model["triangles"], "trimesh reads all triangles")
    pieces = face["piece"].ravel()
    hold(numpy.array_equal(pieces, model["face_pieces"]), "trimesh reads the piece of every face")
    order = numpy.argsort(pieces, kind="stable")
    uv = numpy.stack([vertex["s"].ravel(), vertex["t"].ravel()], axis=1)
    check_map(obj, order, mesh.faces, source, uv, hold)


def check_map(obj, order, faces, source, uv, hold):
    """Corner by corner against the OBJ, whose faces come by piece."""
    hold(numpy.array_equal(source[faces[order]], obj.faces(0)), "corners are the vertices that the OBJ has there")
    hold(numpy.allclose(uv[faces[order]], obj.vt[obj.faces(1)], rtol=0, atol=SINGLE), "corners have the places in the map that the OBJ has")
    hold(first_use(faces), "vertices are in the order of their first use")


def first_use(faces):
    _, first = numpy.unique(faces.ravel(), return_index=True)
    return bool((numpy.diff(first) > 0).all())


def check_glb(path, hold):
    model, obj = model_of(path), Obj(path.with_name("uv.obj"))
    scene = trimesh.load_scene(path, process=False)
    root, extras = raw_root(path)
    scale = model["mm_per_unit"] / 1000
    hold(numpy.allclose(root["scale"], [scale] * 3, rtol=1e-15), "the root node makes metres of the file's units")
    hold(extras["pieces"] == model["pieces"] and extras["input_vertices"] == model["input_vertices"], "the extras count pieces and vertices")
    meshes = [scene.geometry[scene.graph[node][1]] for node in scene.graph.nodes_geometry]
    faces = numpy.concatenate([mesh.faces for mesh in meshes])
    hold(len(faces) == model["triangles"], "trimesh reads all triangles")
    first = meshes[0]
    # All primitives share their vertices.
    hold(all(numpy.array_equal(mesh.vertices, first.vertices) for mesh in meshes), "all primitives have the same vertices")
    source = numpy.asarray(first.vertex_attributes["_SOURCE_VERTEX"]).ravel().astype(int)
    piece = numpy.asarray(first.vertex_attributes["_PIECE"]).ravel().astype(int)
    hold(numpy.array_equal(first.vertices.astype(numpy.float32), obj.v[source].astype(numpy.float32)), "trimesh reads the input's coordinates, to the last bit of single precision")
    hold(len(numpy.unique(source[source < model["input_vertices"]])) == used_vertices(obj, model), "every vertex of the input that a face uses is there")
    order = numpy.argsort(piece[faces[:, 0]], kind="stable")
    uv = numpy.asarray(first.visual.uv)
    if len(meshes) == 1:
        check_map(obj, order, faces, source, uv, hold)
    else:
        hold(same_triangles(obj.v[source[faces]], obj.v[obj.faces(0)], 0), "its triangles are those of the OBJ")
        hold(set(group_names(path)) <= set(scene.graph.nodes), "groups are nodes of their names")
    hold(numpy.allclose(scene.extents, numpy.ptp(first.vertices, axis=0) * scale, rtol=1e-6), "the scene is as large as the thing, in metres")
    image = first.visual.material.baseColorTexture
    hold(image is not None and image.size in {(32, 32), (512, 512)}, "the texture inside is a picture")


def used_vertices(obj, model):
    used = numpy.unique(obj.faces(0))
    return int((used < model["input_vertices"]).sum())


def group_names(path):
    lines = Obj(path.with_name("input.obj")).lines
    return [line.split(None, 1)[1] for line in lines if line.startswith("g ")]


def raw_root(path):
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    root = json.loads(data[20 : 20 + length])["nodes"][0]
    return root, root["extras"]
