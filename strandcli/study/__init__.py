"""Measuring instruments: how right, how fast and how stable everything else is. Nothing that runs presets needs them.

Rooms: `references`, exact solutions that rods are held to; `pictures`, what each approximation of drawing costs;
`stress`, the stability matrix. `motion` is where strands are at each setting of each solver. `sweep` lists what
`strandcli study` can study and carries it out, and `points`, `report` and `chart` make of it what people read; `advice`
chooses settings by one. `bench`, `claims` and `golden` are commands of their own.
"""
