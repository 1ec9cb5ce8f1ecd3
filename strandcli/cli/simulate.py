"""`strandcli simulate`: positions only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..common.counted import counted
from ..errors import UsageError
from ..files import inputs
from . import options
from .progress import Talk, warner
from .render_frames import motion_of
from .values import FrameRange


@click.command()
@options.drawn
@options.folder()
@options.frames
@options.scene_options
@options.threads
@options.checkpoint
@options.keep_going
@options.memory_check
@options.resume_or_overwrite
@options.talk_options
@inputs.recording()
def command(
    preset: str, output: Path, frames: FrameRange | None, threads: int | None, checkpoint: int | None,
    keep_going: bool, memory_check: bool, resume: bool, overwrite: bool, talk: Talk, **scene_settings: Any,
) -> None:  # fmt: skip
    """Simulate PRESET and write the positions only, as positions_0001.npz … and manifest.json.

    'strandcli render --from-cache DIR' draws them.
    """
    scene = options.load_scene(preset, **scene_settings)
    if scene.panels:
        raise UsageError(f"{preset}: draws several panels, each with positions of its own; simulate them one by one")
    numbers = options.frame_numbers(frames, scene)

    from ..plan import checked_plan

    checked_plan(scene, numbers, draw=False, check=memory_check)

    from ..output.positions import PositionsWriter

    emitter = scene.emitter
    writer = PositionsWriter(
        output, numbers, emitter.strands, emitter.particles, overwrite=overwrite, resume=resume, motion=motion_of(scene)
    )
    label = options.preset_name(preset)
    status = "failed"
    with talk.progress(len(writer.wanted), label) as progress:
        try:
            if writer.wanted:
                from ..compiling import runtime

                runtime.start(threads, progress.note)
                from ..run import checkpoints, pipeline

                warn = warner(progress, talk.quiet)
                for frame in pipeline.render(
                    scene,
                    writer.wanted,
                    threads=threads,
                    draw=False,
                    keep_positions=True,
                    keep_going=keep_going,
                    notify=progress.note,
                    warn=warn,
                    checkpoints=checkpoints.of_run(output, checkpoint, warn, progress.note),
                ):
                    if frame.positions is not None:  # they are, where they are asked for
                        writer.write(frame.number, frame.positions, frame.report["error"])
                    progress.checked_step(f"frame {frame.number}")
                if stale := inputs.changed():
                    warn(stale)
            status = "complete"
        except KeyboardInterrupt:
            status = "interrupted"
            raise
        finally:
            data = writer.write_manifest(label, scene.sha256, scene.time.fps, status)
    talk.data(data)
    earlier = f"; {len(writer.earlier)} kept" if writer.earlier else ""
    talk.note(f"{output}: {counted(len(writer.wanted), 'frame')} of positions{earlier}")
