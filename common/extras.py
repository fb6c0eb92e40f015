"""Imports of what only an extra installs; a missing one is told by the extra's name."""

from collections.abc import Iterator
from contextlib import contextmanager

from gymnasium.error import DependencyNotInstalled

__all__ = ["EXTRAS", "MissingExtra", "optional_import"]

EXTRAS = {
    "plot": {"matplotlib"},
    "render": {"pygame", "moviepy", "imageio_ffmpeg", "PIL"},
    "cli": {"typer", "rich"},
    "train": {"stable_baselines3", "sb3_contrib", "threadpoolctl", "torch", "tensorboard", "tqdm", "yaml"},
    "interop": {"minari", "mo_gymnasium", "skrl", "torchrl"},
    "export": {"onnx", "onnxruntime"},
    "demo": {"jinja2"},
    "dask": {"distributed"},
    "explore": {"bokeh"},
    "maps": {"xarray", "zarr"},
    "claims": {"pysindy"},
    "peers": {"envpool", "heyoka", "diffrax", "jax", "mujoco", "reservoirpy"},
}
"""Packages that can be imported by the least extra in `pyproject.toml` that installs them."""

_EXTRA_OF = {package: extra for extra, packages in EXTRAS.items() for package in packages}


class MissingExtra(ModuleNotFoundError, DependencyNotInstalled):
    """A package that an extra installs is missing; the message says how to install it."""


@contextmanager
def optional_import() -> Iterator[None]:
    """Surround imports of optional packages.

    Raises
    ------
    MissingExtra
        If a package of :data:`EXTRAS` cannot be found. Other failures to import are left as they are.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in _EXTRA_OF:
            raise
        extra = _EXTRA_OF[package]
        raise MissingExtra(
            f'{package} is not installed: run `pip install "stickslip[{extra}]"`, or `pip install ".[{extra}]"` in a '
            "checkout",
            name=error.name,
        ) from error
