"""A policy for other programs: a graph of ONNX, or NumPy's archive of its weights."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.extras import optional_import
from ...common.files import atomically
from .description import canonical
from .files import named_weights
from .policy import Policy

__all__ = ["check_onnx", "onnx_actions", "write_npz", "write_onnx"]

_OPERATORS = {"tanh": "Tanh", "relu": "Relu"}
# Of 2021: what runs ONNX on small computers knows them.
_OPSET = 13
_IR_VERSION = 8
# Share of the largest output by which single precision may err.
_LEVEL = 1e-5


def write_onnx(policy: Policy, file: Path) -> None:
    """Write a policy as a graph of ONNX, whole or not at all.

    Its inputs are ``observation``, (n, d) of float32, and, for a policy that takes the weight, ``weight``, (n,) of
    float32; its outputs ``action``, (n,) of int64, and ``outputs``, (n, 2) of float32, as `Policy.outputs` has them but
    in single precision. Its metadata hold the policy's ``description`` as JSON.

    Parameters
    ----------
    policy : Policy
    file : Path

    Raises
    ------
    MissingExtra
        If onnx is not installed.
    OSError
        If it cannot be written.
    """
    # Torch is not needed, and neither is what trained the policy.
    with optional_import():
        import onnx
        from onnx import helper, numpy_helper

    single = onnx.TensorProto.FLOAT
    seen = policy.layers[0].weight.shape[1] - policy.conditioned
    inputs = [helper.make_tensor_value_info("observation", single, ["n", seen])]
    nodes, constants, last = [], named_weights(policy), "observation"
    if policy.conditioned:
        inputs.append(helper.make_tensor_value_info("weight", single, ["n"]))
        constants["axis"] = np.array([1], np.int64)
        nodes.append(helper.make_node("Unsqueeze", ["weight", "axis"], ["column"]))
        nodes.append(helper.make_node("Concat", ["observation", "column"], ["beside"], axis=1))
        last = "beside"
    operator = _OPERATORS[policy.description["network"]["activation"]]
    for k in range(len(policy.layers)):
        end = k == len(policy.layers) - 1
        sums = "outputs" if end else f"sums {k}"
        nodes.append(helper.make_node("Gemm", [last, f"{k}.weight", f"{k}.bias"], [sums], transB=1))
        if not end:
            nodes.append(helper.make_node(operator, [sums], [f"hidden {k}"]))
            last = f"hidden {k}"
    nodes.append(helper.make_node("ArgMax", ["outputs"], ["action"], axis=1, keepdims=0))
    graph = helper.make_graph(
        nodes,
        "policy",
        inputs,
        [
            helper.make_tensor_value_info("action", onnx.TensorProto.INT64, ["n"]),
            helper.make_tensor_value_info("outputs", single, ["n", 2]),
        ],
        [numpy_helper.from_array(value, name) for name, value in constants.items()],
    )
    opsets = [helper.make_opsetid("", _OPSET)]
    model = helper.make_model(graph, producer_name="stickslip", opset_imports=opsets, ir_version=_IR_VERSION)
    helper.set_model_props(model, {"description": canonical(policy.description)})
    onnx.checker.check_model(model, full_check=True)
    atomically(file, lambda path: path.write_bytes(model.SerializeToString()))


def onnx_actions(file: Path, observation: NDArray[np.float32], weight: NDArray[np.float32] | None = None) -> Any:
    """Actions of an exported policy, as onnxruntime computes them.

    Parameters
    ----------
    file : Path
        As `write_onnx` wrote it.
    observation : (n, d) array of float32
    weight : (n,) array of float32, optional
        For a policy that takes it.

    Returns
    -------
    (n,) array of int64

    Raises
    ------
    MissingExtra
        If onnxruntime is not installed.
    """
    with optional_import():
        import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1  # the network is small
    session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
    inputs = {"observation": observation} | ({} if weight is None else {"weight": weight})
    return session.run(["action"], inputs)[0]


def check_onnx(policy: Policy, file: Path, count: int = 1000) -> int:
    """Have onnxruntime act on random observations, and compare with the policy.

    Parameters
    ----------
    policy : Policy
    file : Path
        As `write_onnx` wrote it.
    count : int

    Returns
    -------
    int
        Observations compared: all but those where the two outputs are level to the rounding of single precision.

    Raises
    ------
    ValueError
        If an action differs.
    MissingExtra
        If onnxruntime is not installed.
    """
    rng = np.random.default_rng(0)
    seen = rng.standard_normal((count, policy.layers[0].weight.shape[1] - policy.conditioned)).astype(np.float32)
    weights = rng.random(count).astype(np.float32) if policy.conditioned else None
    outputs = policy.outputs(seen, weights)
    clear = np.abs(outputs[:, 1] - outputs[:, 0]) > _LEVEL * np.abs(outputs).max()
    differ = np.count_nonzero(clear & (onnx_actions(file, seen, weights) != policy.predict(seen, weights)))
    if differ:
        raise ValueError(f"{file} must act as its policy does, it does otherwise on {differ} of {count} observations")
    return int(np.count_nonzero(clear))


def write_npz(policy: Policy, file: Path) -> None:
    """Write a policy as an archive of NumPy's, whole or not at all.

    It holds ``0.weight``, ``0.bias`` and so on, and ``description``, which is JSON in an array of text: ``numpy.load``
    reads all of it without unpickling.

    Parameters
    ----------
    policy : Policy
    file : Path
        Ends in ``.npz``.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    arrays: dict[str, Any] = {**named_weights(policy), "description": np.array(canonical(policy.description))}
    atomically(file, lambda path: np.savez(path, **arrays))
