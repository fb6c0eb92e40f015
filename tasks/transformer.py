"""The crawler as a scikit-learn transformer."""

import warnings
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from ..common.validation import finite_array, number_within, whole_number
from .reservoirs import BodyReservoir, READINGS

__all__ = ["CrawlerReservoir"]


class CrawlerReservoir(TransformerMixin, BaseEstimator):
    """Turn a series into the motion of a crawler that it drives, for a linear readout to follow.

    Rows are samples in order of time. Row k of the result is read while sample k drives the valve: it has absorbed
    the samples up to k and none after it. Each column of the input drives a crawler of its own.

    By default every call of `transform` starts with the body at rest, so that no series leaks into the next, and
    gives one row for every sample. A start at rest is no part of a series, and a transformer in a pipeline may not drop
    its rows, since the target's stay. So the start is washed out beforehand: the body is first driven by `washout`
    copies of the first sample, of which no row is kept. What the first rows lack then is the series' own past.
    `settled` says which rows that are. To keep them out of a fit give them no weight,
    ``model.fit(X, y, ridge__sample_weight=reservoir.settled(X))``, and to keep them out of a score, leave them out.

    Where the series to be transformed goes on from the one that was fitted, as in a `TimeSeriesSplit`, its past is
    known: with ``carry_on=True`` `transform` drives the body through the fitted series first.

    Parameters
    ----------
    groups : Groups, str, mapping, Actuator or None
        As in `stickslip.Groups.of`.
    scene : Scene, mapping or None
        As in `stickslip.Scene.of`. Of a chain every segment is read.
    hold : float or str, in (0, inf)
        Length of a hold, natural units, or "20 ms" where groups is an `Actuator`.
    encoding : {"pulse_width", "threshold", "sigma_delta"}
        How a sample becomes what the valve does; see `stickslip.tasks.encodings` for what each loses.
    holds_per_sample : int, at least 1
        Holds that each sample lasts.
    virtual_nodes : int, at least 1
        Readings a sample, equally spaced in time, the last at its end.
    readings : sequence of str
        Some of "deformation", "velocity", "pressure" and "foot_velocity".
    washout : int, at least 0
        Samples for which the body is driven by the first one, before it.
    input_range : (float, float) or None
        What shuts the valve and what opens it for a whole sample. None takes the least and the greatest value of each
        column that `fit` has seen. Beyond them the valve is shut or open: it can do no more, and `transform` warns.
    tolerance : float, in [1e-15, 1e-2]
        As in `stickslip.simulate`.
    carry_on : bool
        Whether what `transform` is given goes on, without a gap, from where the series that `fit` has seen ends.
        `fit_transform` gives the rows of the fitted series itself, from its start.

    Attributes
    ----------
    n_features_in_ : int
        Columns of the input.
    feature_names_in_ : ndarray of str
        Their names, where it has names.
    input_range_ : ndarray of shape (n_features_in_, 2)
        What shuts the valve and what opens it.
    past_ : ndarray of shape (samples, n_features_in_)
        The series that `fit` has seen, where `carry_on` is set; empty otherwise.

    Examples
    --------
    >>> import numpy as np
    >>> from sklearn.linear_model import Ridge
    >>> from sklearn.pipeline import make_pipeline
    >>> from stickslip import CrawlerReservoir
    >>> u = np.random.default_rng(0).random(600)
    >>> model = make_pipeline(CrawlerReservoir(input_range=(0, 1)), Ridge(1e-6)).fit(u[:400, None], np.roll(u, 1)[:400])
    >>> bool(model.score(u[400:, None], np.roll(u, 1)[400:]) > 0.5)
    True
    """

    def __init__(
        self,
        groups: Any = None,
        *,
        scene: Any = None,
        hold: float | str = 0.5,
        encoding: str = "pulse_width",
        holds_per_sample: int = 1,
        virtual_nodes: int = 4,
        readings: Any = READINGS,
        washout: int = 100,
        input_range: Any = None,
        tolerance: float = 1e-9,
        carry_on: bool = False,
    ) -> None:
        self.groups = groups
        self.scene = scene
        self.hold = hold
        self.encoding = encoding
        self.holds_per_sample = holds_per_sample
        self.virtual_nodes = virtual_nodes
        self.readings = readings
        self.washout = washout
        self.input_range = input_range
        self.tolerance = tolerance
        self.carry_on = carry_on

    def fit(self, X: ArrayLike, y: Any = None) -> Self:
        """Check the parameters, and learn the input's range unless it is given.

        Parameters
        ----------
        X : array_like of shape (samples, columns), or (samples,) for a single one
        y : ignored

        Returns
        -------
        CrawlerReservoir

        Raises
        ------
        TypeError, ValueError
            If a parameter is invalid, or `X` is empty or not finite.
        """
        self._body()
        whole_number("washout", self.washout, 0)
        values = self._validated(X, reset=True)
        if self.input_range is None:
            self.input_range_ = np.stack([values.min(axis=0), values.max(axis=0)], axis=1)
        else:
            given = finite_array("input_range", self.input_range, 1)
            if len(given) != 2 or not given[0] < given[1]:
                raise ValueError(f"input_range must be two ascending numbers, got {self.input_range!r}")
            self.input_range_ = np.tile(given, (values.shape[1], 1))
        self.past_ = (values if self.carry_on else values[:0]).copy()
        return self

    def fit_transform(self, X: ArrayLike, y: Any = None) -> NDArray[np.float64]:
        """Fit, and drive the body by the series itself, from its start.

        Parameters
        ----------
        X, y
            As in `fit`.

        Returns
        -------
        ndarray of shape (samples, features)
            As of `transform`, but that the fitted series does not follow itself.
        """
        self.fit(X, y)
        values = self._validated(X, reset=False)
        return self._driven(self._opened(values), self._held(values))

    def transform(self, X: ArrayLike) -> NDArray[np.float64]:
        """Drive the body by one series, from rest or, with `carry_on`, from where the fitted series has left it.

        Parameters
        ----------
        X : array_like of shape (samples, columns), or (samples,) for a single one

        Returns
        -------
        ndarray of shape (samples, features)
            Named by `get_feature_names_out`.

        Raises
        ------
        ValueError
            If `X` has another number of columns than `fit` has seen, is empty or not finite.

        Warns
        -----
        UserWarning
            If a value is beyond `input_range_`: the body cannot tell it from the end of the range.
        """
        check_is_fitted(self)
        values = self._validated(X, reset=False)
        if not len(self.past_):
            return self._driven(self._opened(values), self._held(values))
        past = np.concatenate([self._held(self.past_), self._opened(self.past_, warn=False)])
        return self._driven(self._opened(values), past)

    def settled(self, X: ArrayLike, tolerance: float = 0.01) -> NDArray[np.bool_]:
        """Tell which rows of a series no longer depend on what was before it.

        The body is driven by the series after its usual start, after the valve has been shut for `washout` samples,
        and after it has been open for as long. A row is settled where from there on no feature differs between the
        three by more than a share of its standard deviation.

        Parameters
        ----------
        X : array_like of shape (samples, columns), or (samples,) for a single one
        tolerance : float, in (0, 1)
            That share.

        Returns
        -------
        ndarray of bool, shape (samples,)
            False in the rows to be left out, which come first. All are False for a body that never forgets.

        Raises
        ------
        ValueError
            If an argument is invalid, or the washout is 0, so that there is no other start to compare with.
        """
        check_is_fitted(self)
        share = number_within("tolerance", tolerance, "(0, 1)")
        whole_number("washout", self.washout, 1)
        values = self._validated(X, reset=False)
        opened, held = self._opened(values, warn=False), self._held(values)
        usual, *others = (self._driven(opened, past) for past in (held, np.zeros_like(held), np.ones_like(held)))
        apart = np.max([np.abs(other - usual) for other in others], axis=0) > share * usual.std(axis=0)
        last = np.flatnonzero(apart.any(axis=1))
        return np.arange(len(values)) > (last[-1] if len(last) else -1)

    def get_feature_names_out(self, input_features: Any = None) -> NDArray[np.object_]:
        """Names of the features, such as "velocity_3" (of the fourth reading of a sample).

        Parameters
        ----------
        input_features : sequence of str, optional
            Names of the columns, which come first where there are several; those that `fit` has seen by default.

        Returns
        -------
        ndarray of str objects, shape (features,)
        """
        check_is_fitted(self)
        count = self.n_features_in_
        seen = getattr(self, "feature_names_in_", None)
        if input_features is None:
            columns = [f"x{i}" for i in range(count)] if seen is None else list(seen)
        else:
            columns = list(input_features)
            if len(columns) != count:
                raise ValueError(f"input_features should have length equal to {count}, got {len(columns)}")
            if seen is not None and columns != list(seen):
                raise ValueError(f"input_features is not equal to feature_names_in_, {list(seen)}, got {columns}")
        names = self._body().feature_names
        if count == 1:
            return np.array(names, dtype=object)
        return np.array([f"{column}_{name}" for column in columns for name in names], dtype=object)

    def _opened(self, values: NDArray[np.float64], *, warn: bool = True) -> NDArray[np.float64]:
        """For how much of a sample the valve is open."""
        low, high = self.input_range_.T
        beyond = (values < low) | (values > high)
        if warn and beyond.any():
            column = int(np.argmax(beyond.any(axis=0)))
            warnings.warn(
                f"X has {beyond.sum()} of {beyond.size} values beyond the fitted range, which drive the body as its "
                f"ends do: column {column} goes from {values[:, column].min():g} to "
                f"{values[:, column].max():g}, and was fitted for {low[column]:g} to {high[column]:g}",
                stacklevel=4,
            )
        # A column that never varied shuts the valve.
        return np.clip((values - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0)

    def _held(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The start that is washed out: the first sample, `washout` times."""
        washout = whole_number("washout", self.washout, 0)
        return np.repeat(self._opened(values[:1], warn=False), washout, axis=0)

    def _driven(self, opened: NDArray[np.float64], past: NDArray[np.float64]) -> NDArray[np.float64]:
        """States of the body driven by a past and what follows it, without the past's rows."""
        body = self._body()
        return np.hstack([body(column)[len(past) :] for column in np.concatenate([past, opened]).T])

    def _body(self) -> BodyReservoir:
        return BodyReservoir(
            groups=self.groups,
            scene=self.scene,
            hold=self.hold,
            encoding=self.encoding,
            holds_per_sample=self.holds_per_sample,
            virtual_nodes=self.virtual_nodes,
            readings=self.readings,
            tolerance=self.tolerance,
        )

    def _validated(self, X: ArrayLike, *, reset: bool) -> NDArray[np.float64]:
        dimensions = X.ndim if hasattr(X, "ndim") else np.asarray(X).ndim
        if dimensions == 1 and (reset or self.n_features_in_ == 1):
            X = np.asarray(X).reshape(-1, 1)
        values: NDArray[np.float64] = validate_data(self, X, dtype=np.float64, reset=reset)
        return values
