"""Patches of Numba's compiler that spare it double work; for worker processes alone, which compile nothing else.

A kernel of a few hundred lines takes Numba seconds, most of them in Python. Nothing here changes what kernels compute.
All of it depends on Numba's insides, of the versions that it has been tested with; with any other nothing is patched.
"""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Sequence
from typing import Any

TESTED = ("0.68",)
"""Versions of Numba."""
_LOOP = ("__numba_parfor_gufunc", "<numba.np.ufunc.wrappers._GufuncWrapper", "parallelgufuncwrapper")
"""Prefixes of names: the body of a parallel loop, its caller for a part of the range, and what divides the range."""


class Compilation:
    """State of the kernel that is being compiled, with all functions that it calls."""

    def __init__(self) -> None:
        self.depth = 0
        self.calls: dict[Any, tuple[Any, Any]] = {}
        """Signature and implementation key by call."""
        self.flags: dict[int, Any] = {}
        """Flags by their id, kept alive so that no other object gets the id."""
        self.environments: list[tuple[str, Any]] = []
        """Of functions without machine code of their own: symbol in the kernel, and environment object."""

    def begin(self) -> None:
        """Note that a function begins to be compiled, within the compiler's lock."""
        self.depth += 1

    def end(self) -> None:
        """Note that it has been compiled, or could not be; after the outermost one, set environments."""
        self.depth -= 1
        if self.depth > 0:
            return
        self.calls.clear()
        self.flags.clear()
        waiting, self.environments = self.environments, []
        for name, environment in waiting:
            _set_environment(name, environment)

    def is_part(self, library: Any) -> bool:
        """Whether a library is for kernels alone, each of which holds a copy: it needs no machine code."""
        from numba.core.targetconfig import ConfigStack

        flags = ConfigStack.top_or_none()
        bare = flags is not None and flags.no_cpython_wrapper and flags.no_cfunc_wrapper
        return self.depth > 0 and (bare or library.name.startswith(_LOOP))


kernel = Compilation()


def _set_environment(name: str, environment: Any) -> None:
    """Store the address of a function's environment in its symbol, where linked machine code has one."""
    from numba.core.registry import cpu_target

    address = cpu_target.target_context.codegen()._engine.get_global_value_address(name)
    if address:
        (ctypes.c_void_p * 1).from_address(address)[0] = ctypes.c_void_p(id(environment))


def _raise_gc_threshold() -> None:
    """Collect garbage seldom, what has been imported never: Numba's trees are large, and little of them is garbage.

    Not at all would spare no more, and memory would grow without bound in a process that compiles for hours.
    """
    gc.freeze()
    gc.set_threshold(1_000_000, 20, 5)


def _unregister_lock_callbacks() -> None:
    """Unregister llvmlite's lock callbacks, which time each of a hundred thousand calls."""
    from llvmlite.binding import ffi

    for pair in list(getattr(getattr(ffi.lib, "_lock", None), "_cblist", ())):
        ffi.unregister_lock_callback(*pair)


PATCHES = (
    "emit_whole_kernels", "simplify_functions_briefly", "memoise_call_types", "run_passes_untimed",
    "compute_liveness_lazily", "raise_gc_threshold", "unregister_lock_callbacks",
)  # fmt: skip
"""Each was measured alone when it was written: without any but the first, kernels take 9 to 15 % longer to compile;
without the first over 40 %, which has come to spare another 11 % since. The second makes code 6 % shorter as well."""


def patch(without: Sequence[str] = ()) -> None:
    """Patch Numba in this process; once, before the first kernel is compiled. ``without``: names of `PATCHES`."""
    import numba
    from numba.core import event

    if numba.__version__.rpartition(".")[0] not in TESTED:
        return

    class Compiling(event.Listener):
        def on_start(self, happening: Any) -> None:
            kernel.begin()

        def on_end(self, happening: Any) -> None:
            kernel.end()

    event.register("numba:compile", Compiling())
    for part in PATCHES:
        if part in without:
            continue
        try:
            globals()[f"_{part}"]()
        except (ImportError, AttributeError):
            continue


def _emit_whole_kernels() -> None:
    """Emit machine code for whole kernels alone, and optimise a parallel loop once.

    Numba optimises a loop's body by itself, in its caller, in that one's caller and in the kernel. Here it is optimised
    by itself, where its arrays are known not to overlap, and linked to the kernel afterwards. What loops and kernels
    call is optimised where it has been inlined, not by itself before that.
    """
    from numba.core.codegen import CPUCodeLibrary, JITCPUCodegen

    link, finish, optimise, note = (
        CPUCodeLibrary.finalize, CPUCodeLibrary._finalize_final_module, CPUCodeLibrary._optimize_final_module,
        JITCPUCodegen.set_env,
    )  # fmt: skip

    def link_loops_last(self: Any) -> None:
        mine = kernel.depth > 0 and not self.name.startswith(_LOOP)
        self._loops = [one for one in self._linking_libraries if mine and one.name.startswith(_LOOP[1:])]
        self._linking_libraries = [one for one in self._linking_libraries if one not in self._loops]
        link(self)

    def emit_unless_part(self: Any) -> None:
        # what comes from the cache may be called by Python whoever asked for it, and its machine code is there
        if getattr(self, "_compiled_object", None) or not kernel.is_part(self):
            finish(self)
            return
        self._finalize_dynamic_globals()
        self._finalized = True

    def optimise_module(self: Any) -> None:
        if self.name.startswith(_LOOP[0]) or not kernel.is_part(self):
            optimise(self)
        for loop in getattr(self, "_loops", ()):
            self._reload_init.update(loop._reload_init)
            self._final_module.link_in(loop._get_module_for_linking(), preserve=True)

    def set_environment_or_wait(self: Any, name: str, environment: Any) -> None:
        if kernel.depth == 0 or self._engine.get_global_value_address(name):
            note(self, name, environment)
        else:
            kernel.environments.append((name, environment))

    CPUCodeLibrary.finalize = link_loops_last  # type: ignore[method-assign]
    CPUCodeLibrary._finalize_final_module = emit_unless_part  # type: ignore[method-assign]
    CPUCodeLibrary._optimize_final_module = optimise_module  # type: ignore[method-assign]
    JITCPUCodegen.set_env = set_environment_or_wait  # type: ignore[method-assign]


def _simplify_functions_briefly() -> None:
    """Make functions small before they are linked, by three passes: the rest run once they have been inlined."""
    import llvmlite.binding as llvm
    from numba.core.codegen import CPUCodeLibrary

    def simplify(self: Any, module: Any) -> None:
        module.data_layout = self._codegen._data_layout
        builder = self._codegen._pass_builder()
        for function in module.functions:
            if not function.is_declaration:
                passes = llvm.create_new_function_pass_manager()
                passes.add_sroa_pass()
                passes.add_simplify_cfg_pass()
                passes.add_instruction_combine_pass()
                passes.add_refprune_pass()
                passes.run(function, builder)

    CPUCodeLibrary._optimize_functions = simplify  # type: ignore[method-assign]


def _memoise_call_types() -> None:
    """Resolve a call of a Numba function once for each function that is compiled, not at each call and type pass."""
    from numba.core.targetconfig import ConfigStack
    from numba.core.types import Function

    ask = Function.get_call_type

    def call_type_once(self: Any, context: Any, args: Any, kws: Any) -> Any:
        flags = ConfigStack.top_or_none()
        if kernel.depth == 0 or kws or flags is None:
            return ask(self, context, args, kws)
        kernel.flags[id(flags)] = flags
        call = (id(flags), id(context), self, tuple(args))
        if call not in kernel.calls:
            signature = ask(self, context, args, kws)
            kernel.calls[call] = signature, self._impl_keys[signature.args]  # type: ignore[union-attr]
        signature, lowered_by = kernel.calls[call]
        self._impl_keys[signature.args] = lowered_by  # other settings may have put theirs there
        return signature

    Function.get_call_type = call_type_once  # type: ignore[method-assign]


def _run_passes_untimed() -> None:
    """Run passes without timers, without descriptions for listeners, and without checks of Numba's own rules."""
    from numba.core import errors
    from numba.core.compiler_machinery import PassManager

    run = PassManager._runPass

    def run_untimed(self: Any, index: int, one: Any, state: Any) -> None:
        if kernel.depth == 0 or self._ENFORCING:
            run(self, index, one, state)
            return
        one.analysis = self._analysis
        with errors.new_error_context("Pass {name}", name=one.name()):  # type: ignore[attr-defined]
            one.run_initialization(state)
            one.run_pass(state)
            one.run_finalizer(state)

    PassManager._runPass = run_untimed  # type: ignore[method-assign]


def _compute_liveness_lazily() -> None:
    """Compute the lifetimes of variables when they are asked for, not after each pass, and the variables that are alive
    at the entry of blocks only where generators and object mode ask for them."""
    from numba.core import analysis, transforms
    from numba.core.ir import FunctionIR
    from numba.core.postproc import PostProcessor, VariableLifetime

    run, ask = PostProcessor.run, FunctionIR.get_block_entry_vars

    def run_without_liveness(self: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
        function = self.func_ir
        if kernel.depth == 0 or function.is_generator:
            run(self, emit_dels, extend_lifetimes)
            return
        function.blocks = transforms.canonicalize_cfg(function.blocks)
        function.variable_lifetime = VariableLifetime(function.blocks)
        function.generator_info = None
        function.block_entry_vars.clear()
        if emit_dels:
            self._insert_var_dels(extend_lifetimes=extend_lifetimes)

    def entry_variables(self: Any, block: Any) -> Any:
        if block not in self.block_entry_vars:
            lives = VariableLifetime(self.blocks)
            alive = analysis.compute_live_variables(
                lives.cfg, self.blocks, lives.usedefs.defmap, lives.deadmaps.combined
            )
            self.block_entry_vars.update((one, alive[place]) for place, one in self.blocks.items())
        return ask(self, block)

    PostProcessor.run = run_without_liveness  # type: ignore[method-assign]
    FunctionIR.get_block_entry_vars = entry_variables  # type: ignore[method-assign]
