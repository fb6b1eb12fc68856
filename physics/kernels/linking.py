"""Linking: each kernel is optimised once, as a whole, together with all that it calls.

numba compiles a callee to machine code of its own, and again within every caller, and that caller
within its own caller: a kernel of five levels is optimised five times. A callee whose sums may be
reordered is then in memory in several versions, each with other bits. Here a function that a kernel
calls is a *part*: unoptimised LLVM code, without machine code and without an entry point for
Python. A *kernel*, which Python calls, links the parts, makes them internal to its module, and is
optimised and compiled to machine code once.
"""

from collections.abc import Callable
from typing import Any

from numba.core import codegen, compiler, registry

_codegen: Any = codegen  # these three without types
_compiler: Any = compiler
_registry: Any = registry
_ENVIRONMENT = "_ZN08NumbaEnv"  # prefix of the names of a function's global variables in numba


class Kernel(_registry.CPUDispatcher):  # type: ignore[misc]
    """A compiled function: a kernel when Python calls it, a part when a kernel calls it."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        """Compile nothing yet; the options are those of `numba.njit`."""
        options = {"nopython": True, "boundscheck": None, **options}
        part = {**options, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        super().__init__(function, targetoptions=options, pipeline_class=_KernelCompiler)
        self._part = _registry.CPUDispatcher(
            function, targetoptions=part, pipeline_class=_PartCompiler
        )

    @property
    def _numba_type_(self) -> Any:
        """The numba type that compiled code uses: that of the part."""
        return self._part._numba_type_


class _KernelLibrary(_codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of a kernel."""

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if function.linkage == _codegen.ll.Linkage.linkonce_odr:
                function.linkage = _codegen.ll.Linkage.internal
        super()._optimize_final_module()

    def _finalize_specific(self) -> None:
        super()._finalize_specific()
        for variable in self._final_module.global_variables:
            if variable.name.startswith(_ENVIRONMENT):
                environment = _compiler.lookup_environment(variable.name)
                if environment is not None:
                    self._codegen.set_env(variable.name, environment)


class _PartLibrary(_codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of a part, which waits to be linked."""

    @property
    def codegen(self) -> Any:
        return _WithoutEnvironments(self._codegen)

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        del name
        self._ensure_finalized()
        return 0


class _WithoutEnvironments:
    """A codegen for code whose global variables are not in memory yet."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: Any) -> None:
        del name, environment


class _KernelCompiler(_compiler.Compiler):  # type: ignore[misc]
    """numba's compiler, for a kernel."""

    def __init__(self, typing: Any, target: Any, library: Any, *others: Any) -> None:
        super().__init__(typing, target, library or _new(_KernelLibrary, target), *others)


class _PartCompiler(_compiler.Compiler):  # type: ignore[misc]
    """numba's compiler, for a part."""

    def __init__(self, typing: Any, target: Any, library: Any, *others: Any) -> None:
        super().__init__(typing, target, library or _new(_PartLibrary, target), *others)


def _new(library: type[Any], target: Any) -> Any:
    """An empty library, whose code can be kept on disk."""
    result = library(target.codegen(), library.__name__)
    result.enable_object_caching()
    return result
