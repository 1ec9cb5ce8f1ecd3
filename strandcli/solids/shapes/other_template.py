"""The text of the module that `other_code` writes for the kinds of solids that a scene has."""

MODULE = '''\
"""Solids that have no kernels of their own, written by strandcli.solids.shapes.other_code for: {title}."""

from typing import Any, NamedTuple

import numpy as np

from strandcli.constants import W
from strandcli.jit import device, function, inlined
from strandcli.solids.kernels.distance_field import gradient, look_in_world, march, number, outward, own
from strandcli.solids.kernels.distance_field import FINE, hides_by_distance, in_world, own_direction, put_outside
from strandcli.solids.kernels.distance_field import ray_in_own, rounded
from strandcli.solids.kernels.segment_depth import deepest_about_some, deepest_of_all_places, deepest_of_some
from strandcli.solids.kernels.segment_depth import put_segment_outside
{imports}

class {name}(NamedTuple):
    """`strandcli.solids.Solids` and solids of these kinds."""

    spheres: Any
    capsules: Any
    planes: Any
    boxes: Any
    others: Any
{fields}

class Others_{name}(NamedTuple):
    """Solids of these kinds, and the arrays of their shapes."""

    rows: Any
{fields}

class Lone{name}({name}):
    """The same where there are no solids but these."""

    built_in = False


Others = Others_{name}


@device
def among(solids):
    """Solids of these kinds among all."""
    return Others({given})


@device
def distance_in_own(p, m, u, v, w):
    """Distance of a point, in the frame of solid m, from its surface."""
{distance}

@device
def distance(p, m, x, y, z):
    """Distance of a point from the surface of solid m."""
    u, v, w = own(p, m, x, y, z)
    return distance_in_own(p, m, u, v, w)
{distances}
@device
def bounds(p, m):
    """Low and high corner, in the frame of solid m, of a box that no point is nearer to the solid than to."""
    around = number(p, m, {reach})
{bounds}

@device
def normal(p, m, x, y, z):
    """Its unit outward normal where the surface is nearest to a point."""
    u, v, w = own(p, m, x, y, z)
{normal}

@device
def deepest(p, m, begin, edge):
    """The share of a segment after which it is deepest in it, and the depth there."""
{deepest}

@device
def meet(p, m, x, y, z, dx, dy, dz, end):
    """Where a ray that begins outside of solid m meets it, in units of |d|; inf where it does not up to `end`."""
    u, v, w, a, b, c = ray_in_own(p, m, x, y, z, dx, dy, dz)
{meet}
{meets}
@device
def hides(p, m, x, y, z, way, reach, skin):
    """Whether solid m stands between a point and a light at reach along a unit vector."""
{ray}{hides}{look}{drift}
Solids, LoneSolids = {name}, Lone{name}
Solids.distance, Solids.normal, Solids.deepest, Solids.meet = distance, normal, deepest, meet
Solids.hides, Solids.among, Solids.look, Solids.folds = hides, among, {has_look}, {folds}
Solids.distance_in_own, Solids.distances_in_own = distance_in_own, {has_distances}
Solids.slopes_in_own = {has_slopes}
Solids.bounds, Solids.meets, Solids.detailed = bounds, {has_meets}, {detailed}
Solids.kinds = {kinds}
drift = {has_drift}


@function
def distances(p, m, points, out):
    """The distances (k,) of points (k, 3) from solid m."""
    for k in range(points.shape[0]):
        out[k] = distance(p, m, points[k, 0], points[k, 1], points[k, 2])


def collide(x, parent, grandparent, root, length, p, i, n):
    """Put particles inside of solids onto their surfaces, as `strandcli.solids.kernels.sphere.collide`."""
    for m in range(p.rows.shape[0]):
        for k in range(W):
            x[k], x[W + k], x[2 * W + k] = put_outside(
                distance, normal, p, m, x[k], x[W + k], x[2 * W + k], np.float32(0.0)
            )


def catch(x, parent, grandparent, root, length, p, i, n):
    """Bring segments out of solids by turning them."""
    for m in range(p.rows.shape[0]):
        for k in range(W):
            begin = parent[k], parent[W + k], parent[2 * W + k]
            x[k], x[W + k], x[2 * W + k] = put_segment_outside(
                normal, deepest, p, m, begin, x[k], x[W + k], x[2 * W + k]
            )
'''
RAY = "    u, v, w, a, b, c = ray_in_own(p, m, x, y, z, way[0], way[1], way[2])\n"
DISTANCES = '''

@inlined
def distances_in_own(p, m, u, v, w):
    """Distances of vectors of points, in the frame of solid m, from its surface."""
{code}
'''
SLOPES = '''

@inlined
def slopes_in_own(p, m, u, v, w):
    """The same, and their gradients."""
{code}
'''
MEETS = '''

@device
def meets(p, m, rays, found):
    """Where rays first meet solid m, of its own frame, as `meets` of `SolidShape`."""
{code}
'''
DRIFT = '''

@device
def drift_of(p, m, x, y, z):
    """How far the point of the surface of solid m nearest to a point came since the step before."""
    u, v, w = own(p, m, x, y, z)
{code}

'''
LOOK = '''

@device
def look(p, m, x, y, z, eye, width, before):
    """How solid m looks at a point of its surface: the normal, where shadow rays begin, and the colour; a negative one
    is that of the solid. And a number, which comes back as ``before`` with a point nearby; -1: none. eye: unit vector
    to the eye; width: that of a pixel there."""
    u, v, w = own(p, m, x, y, z)
    eye = own_direction(p, m, eye[0], eye[1], eye[2])
{code}

'''
