"""Surfaces and tetrahedral meshes: reading, checking, meshing, locating, selecting, rays."""

from ._ball import ball_mesh
from ._beam import in_beam
from ._box import box_mesh
from ._build import mesh_from_cells
from ._check_surface import check_surface
from ._cylinder import cylinder_mesh
from ._geometry import cell_quality, cell_volumes, face_areas, triangle_normals
from ._inner_edges import inner_edges
from ._locate import SurfacePoints, locate
from ._mesh import Mesh
from ._nearest_triangle import nearest_triangle
from ._node_count import expected_nodes
from ._patches import face_centres, faces_in_box, faces_towards, faces_where
from ._promote import linear, promote
from ._ray_casting import Caster, RayHits, caster_of, first_hits, unhindered
from ._read_surface import read_surface
from ._resolution import Resolution, resolution
from ._self_intersection import crossing_pairs
from ._simplify import simplified
from ._sizing import Fine, Sizing, heat_depth
from ._sizing_from_physics import sizing_from_physics
from ._surface import Surface
from ._tetrahedralise import tetrahedralise

__all__ = [
    "Caster",
    "Fine",
    "Mesh",
    "RayHits",
    "Resolution",
    "Sizing",
    "Surface",
    "SurfacePoints",
    "ball_mesh",
    "box_mesh",
    "caster_of",
    "cell_quality",
    "cell_volumes",
    "check_surface",
    "crossing_pairs",
    "cylinder_mesh",
    "expected_nodes",
    "face_areas",
    "face_centres",
    "faces_in_box",
    "faces_towards",
    "faces_where",
    "first_hits",
    "heat_depth",
    "in_beam",
    "inner_edges",
    "linear",
    "locate",
    "nearest_triangle",
    "mesh_from_cells",
    "promote",
    "read_surface",
    "resolution",
    "simplified",
    "sizing_from_physics",
    "tetrahedralise",
    "triangle_normals",
    "unhindered",
]
