"""What a map says once its seeds are taken together, and in SI."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ...common.validation import number_within
from ...crawler import Actuator

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["in_si", "over_seeds"]


def over_seeds(found: xr.Dataset, confidence: float = 0.95) -> xr.Dataset:
    """Means over the seeds, with their standard errors and Student's intervals.

    Parameters
    ----------
    found : xarray.Dataset
        As from `parameter_map`.
    confidence : float, in (0, 1)

    Returns
    -------
    xarray.Dataset
        Of each variable `name` with seeds the mean ``name``, its standard error ``name_error``, and the ends
        ``name_low`` and ``name_high`` of the interval of confidence, ``mean -+ t error`` with the quantile t of
        Student's law with ``seeds - 1`` degrees of freedom and no end below the variable's `valid_min`. For a single
        seed all but the mean are not a number. What has no seeds stays as it is.
    """
    from scipy.special import stdtrit

    confidence = number_within("confidence", confidence, "(0, 1)")
    seeds = found.sizes["seed"]
    result = found.drop_dims("seed")
    for name, each in found.data_vars.items():
        if "seed" not in each.dims:
            continue
        mean = each.mean("seed", skipna=False, keep_attrs=True)
        error = (
            each.std("seed", skipna=False, ddof=1, keep_attrs=True) / math.sqrt(seeds) if seeds > 1 else mean * np.nan
        )
        half = error * float(stdtrit(max(seeds - 1, 1), (1.0 + confidence) / 2.0))
        least = each.attrs.get("valid_min", -math.inf)
        said, interval = str(each.attrs.get("long_name", name)), f"{confidence:.0%} interval"
        for suffix, values, what in (
            ("", mean, said),
            ("_error", error, f"standard error of {said}"),
            ("_low", np.maximum(mean - half, least), f"lower end of the {interval} of {said}"),
            ("_high", mean + half, f"upper end of the {interval} of {said}"),
        ):
            result[f"{name}{suffix}"] = values.assign_attrs(each.attrs, long_name=what)
    return result


def in_si(found: xr.Dataset, actuator: Actuator) -> xr.Dataset:
    """A map in seconds, metres and joules, of one actuator's scales.

    Parameters
    ----------
    found : xarray.Dataset
        As from `parameter_map`, or from `over_seeds`.
    actuator : Actuator
        Whose scales to use. Groups and other numbers without a unit stay as they are.

    Returns
    -------
    xarray.Dataset
    """
    scales = actuator.scales
    units = {
        "t_c": (scales.time, "s"),
        "z_c": (scales.length, "m"),
        "1 / t_c": (1.0 / scales.time, "1 / s"),
        "z_c / t_c": (scales.length / scales.time, "m / s"),
        "P_max A_0": (scales.force, "N"),
        "P_max A_0 z_c": (scales.energy, "J"),
    }
    result = found.copy()
    for name, each in found.variables.items():
        if each.attrs.get("units") in units:
            factor, unit = units[each.attrs["units"]]
            converted = each * factor
            converted.attrs = {**each.attrs, "units": unit}
            result[name] = converted
    return result
