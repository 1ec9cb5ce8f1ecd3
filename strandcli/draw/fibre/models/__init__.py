"""Fibre models, one driver each: how a strand scatters light once. `common.registry.FIBRES` finds them by name.

A fibre model is a module or object with

* ``name`` — what `material.model` says;
* ``tables(material)`` — what its kernel reads, or None where the material has no highlights: a NamedTuple of float32
  arrays, or an object that has one as ``arrays`` and

  * ``absorption``, (3,) σ_a in 1/radius that the tables stand for, which the row `EXTRA` is the difference from.

The NamedTuple's class is decorated with `strandcli.draw.fibre.kernels.highlights.shaded_by` and a function compiled
with `strandcli.jit.device`: (work, n, lights, i, tables) adds to the radiance of the first n vertices of a batch what
they scatter of light number i. Rows of work are those of `strandcli.draw.common.kernels.batch`. The function reads
`TX`, `LX`, `EX` (unit tangent, to the light, to the eye, three rows each), `ARRIVES` (what arrives of the light),
`COLOUR` and `EXTRA`, and adds arrives · power · S cos θ_l to `RADIANCE`, no other cosine, where power is lights[i,
POWER_R] and so on (`light_columns`). The rows in the stage "highlights" are its own to write to.

It may have, too,

* ``roughness(material)`` — Chiang's β_n at which the colour of a mass of strands and their absorption correspond
  (`strandcli.draw.fibre.pigment`); without it `material.beta_n`;
* ``Parameters`` — a frozen dataclass made of the helpers of `strandcli.scene.fields`: its own settings, which presets
  write under `material.parameters`. Shipped models' settings stand in `material` itself;
* ``plan(material)`` — in words what `strandcli plan` says of it;
* ``memory(material)`` — bytes that its tables take;
* ``columns(material)`` — its lobes in each column across a wide strand (`strandcli.draw.fibre.tables`), for
  models with azimuthal tables; without them the light is even across;
* ``optics(material)`` — how `strandcli study --axis tables` measures it (`strandcli.study.pictures.optics.Optics`).

Drivers import numpy and numba only inside of functions: `strandcli plan` does without.
"""
