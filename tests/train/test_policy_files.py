"""A policy's files: what is read is what was written, and what was not is refused in one sentence."""

import json
import pickle
from hashlib import sha256
from itertools import pairwise

import numpy as np
import pytest
from safetensors.numpy import load, save

from stickslip.train.policies import Policy, read_policy, write_policy
from stickslip.train.policies.description import canonical, checked, FORMAT

SIZES = [6, 3, 2]


def described(**changes):
    return {
        "format": FORMAT,
        "environment": "StickSlipCrawler-v0",
        "env_kwargs": {"dither": 0.1, "scene": {"slope": -0.1}},
        "groups": {"duffing": 0.5},
        "observation_space": {"type": "Box", "shape": [5], "low": ["-inf"] * 5, "high": ["inf"] * 5},
        "action_space": {"type": "Discrete", "n": 2, "start": 0},
        "conditioned": True,
        "network": {"sizes": SIZES, "activation": "tanh", "outputs": "logits"},
        "algorithm": {"name": "ppo", "steps": 7},
        "versions": {"stickslip": "0.1.0", "Prüfstand": "2"},
        "scores": {"speed": {"mean": 0.1 + 0.2}, "seeds": [1, 2]},
    } | changes


def layers(sizes=SIZES, dtype=np.float32):
    rng = np.random.default_rng(0)
    return [(rng.normal(size=(b, a)).astype(dtype), rng.normal(size=b).astype(dtype)) for a, b in pairwise(sizes)]


@pytest.fixture
def kept(tmp_path):
    write_policy(Policy(layers(), described()), tmp_path / "knee-0.2")
    return tmp_path / "knee-0.2"


def weights_of(path):
    return path.with_name(path.name + ".safetensors")


def description_of(path):
    return path.with_name(path.name + ".json")


def test_what_is_read_is_what_was_written(kept):
    written = Policy(layers(), described())
    assert sorted(file.name for file in kept.parent.iterdir()) == ["knee-0.2.json", "knee-0.2.safetensors"]
    for path in (kept, weights_of(kept), description_of(kept)):
        policy = read_policy(path)
        assert policy.description == written.description == described()
        for layer, (weight, bias) in zip(policy.layers, layers(), strict=True):
            np.testing.assert_array_equal(layer.weight, weight)
            np.testing.assert_array_equal(layer.bias, bias)
    # A second writing of the same policy makes the same files, and anybody's safetensors reads the one.
    before = weights_of(kept).read_bytes(), description_of(kept).read_bytes()
    write_policy(policy, kept)
    assert (weights_of(kept).read_bytes(), description_of(kept).read_bytes()) == before
    assert {name: each.shape for name, each in load(before[0]).items()} == {
        "0.weight": (3, 6),
        "0.bias": (3,),
        "1.weight": (2, 3),
        "1.bias": (2,),
    }
    told = json.loads(before[1])
    assert "Prüfstand" in before[1].decode("utf-8")  # as people read it
    assert told["sha256"] == sha256(before[0]).hexdigest()


def refusal(path):
    with pytest.raises(ValueError, match=path.name) as caught:
        read_policy(path)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert len(message) < 800
    return message


def forge(path, tensors, description):
    """Write files whose digests are right: whoever forges them can compute one."""
    weights = save(tensors, {"description_sha256": sha256(canonical(description).encode()).hexdigest()})
    weights_of(path).write_bytes(weights)
    told = {**description, "sha256": sha256(weights).hexdigest()}
    description_of(path).write_text(json.dumps(told), encoding="utf-8")


def tensors(**changes):
    each = {}
    for k, (weight, bias) in enumerate(layers()):
        each |= {f"{k}.weight": weight, f"{k}.bias": bias}
    return each | changes


def test_the_forger_forges_well(tmp_path):
    forge(tmp_path / "p", tensors(), described())
    assert read_policy(tmp_path / "p").description == described()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"1.weight": np.zeros((2, 4), np.float32)}, r"weights must have the shapes"),
        ({"1.bias": np.zeros((1, 2), np.float32)}, r"weights must have the shapes"),
        ({"1.weight": np.zeros((2, 3), np.float64)}, "weights must be float32, got float64"),
        ({"1.weight": np.zeros((2, 3), np.int32)}, "weights must be float32, got int32"),
        ({"0.bias": np.array([0, np.nan, 0], np.float32)}, "weights must be finite, got NaN or infinity"),
        ({"0.bias": np.array([0, np.inf, 0], np.float32)}, "weights must be finite, got NaN or infinity"),
        ({"2.bias": np.zeros(2, np.float32)}, r"weights must be named \['0.bias', "),
    ],
)
def test_forged_weights_are_refused(tmp_path, change, message):
    forge(tmp_path / "p", tensors(**change), described())
    with pytest.raises(ValueError, match=rf"p\.json or its \.safetensors is refused: {message}"):
        read_policy(tmp_path / "p")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "rl-zoo3"}, "format must be 'stickslip policy 1', got 'rl-zoo3'"),
        ({"conditioned": 1}, "conditioned must be a JSON true or false, got 1"),
        ({"conditioned": False}, r"observation_space must be a Box of shape \[6\]"),
        ({"env_kwargs": []}, r"env_kwargs must be a JSON object, got \[\]"),
        ({"scores": None}, "scores must be a JSON object, got None"),
        ({"environment": 3}, "environment must be a JSON string, got 3"),
        ({"algorithm": {}}, r"algorithm must have a name, got \{\}"),
        ({"wheels": 4}, r"description must have exactly .* unknown \['wheels'\]"),
        ({"action_space": {"type": "Discrete", "n": 3}}, "action_space must be"),
        (
            {"network": {"sizes": SIZES, "activation": "__import__('os')", "outputs": "logits"}},
            "activation must be one of",
        ),
        ({"network": {"sizes": SIZES, "activation": "tanh", "outputs": "magic"}}, "outputs must be one of"),
        ({"network": {"sizes": [6, 10**9, 2], "activation": "tanh", "outputs": "logits"}}, "sizes must be 2 to 17"),
        ({"network": {"sizes": [6, True, 2], "activation": "tanh", "outputs": "logits"}}, "sizes must be 2 to 17"),
        ({"network": {"sizes": [6, 3, 3], "activation": "tanh", "outputs": "logits"}}, "sizes must end with 2"),
        ({"network": {"sizes": [2], "activation": "tanh", "outputs": "logits"}}, "sizes must be 2 to 17"),
        ({"network": {}}, r"network must have exactly \['sizes', 'activation', 'outputs'\]; it lacks"),
    ],
)
def test_forged_descriptions_are_refused(tmp_path, change, message):
    forge(tmp_path / "p", tensors(), described(**change))
    with pytest.raises(ValueError, match=rf"p\.json or its \.safetensors is refused: {message}"):
        read_policy(tmp_path / "p")


@pytest.mark.parametrize(
    ("sizes", "fits"),
    [
        ([6, 1, 2], True),
        ([6, 0, 2], False),
        ([6, 4096, 2], True),
        ([6, 4097, 2], False),
        ([6, 2], True),
        ([6, *[1] * 15, 2], True),
        ([6, *[1] * 16, 2], False),
        ([6, 3.0, 2], False),
    ],
)
def test_networks_have_up_to_16_layers_up_to_4096_wide(sizes, fits):
    description = described(network={"sizes": sizes, "activation": "relu", "outputs": "action values"})
    if fits:
        assert checked(description) == description
    else:
        with pytest.raises(ValueError, match=r"^sizes must be 2 to 17 whole numbers in \[1, 4096\], got \[6, "):
            checked(description)


def test_a_refusal_shows_the_begin_of_what_is_long():
    network = {"sizes": SIZES, "activation": "x" * 1000, "outputs": "logits"}
    with pytest.raises(ValueError, match=r"activation") as caught:
        checked(described(network=network))
    assert str(caught.value) == f"activation must be one of ['tanh', 'relu'], got '{'x' * 199}..."
    with pytest.raises(ValueError, match=r"^activation must be one of \['tanh', 'relu'\], got 'x{198}'$"):
        checked(described(network={**network, "activation": "x" * 198}))


@pytest.mark.parametrize("name", [name for name in described() if name != "format"])
def test_what_lacks_something_is_refused(tmp_path, name):
    description = described()
    del description[name]
    forge(tmp_path / "p", tensors(), description)
    assert f"must have exactly {list(described())}; it lacks ['{name}']" in refusal(tmp_path / "p")


def test_one_changed_bit_of_the_weights_is_noticed(kept):
    content = bytearray(weights_of(kept).read_bytes())
    for place in (0, 20, len(content) - 1):
        content[place] ^= 1
        weights_of(kept).write_bytes(content)
        assert "it was changed" in refusal(kept)
        content[place] ^= 1


@pytest.mark.parametrize(
    "change", [('"dither": 0.1', '"dither": 0.0'), ("0.30000000000000004", "9.0"), ("tanh", "relu")]
)
def test_a_changed_description_is_noticed(kept, change):
    text = description_of(kept).read_text(encoding="utf-8")
    assert change[0] in text
    description_of(kept).write_text(text.replace(*change), encoding="utf-8")
    assert "it was changed" in refusal(kept)


def test_files_of_two_policies_are_no_policy(kept):
    other = kept.with_name("other")
    write_policy(Policy(layers(), described(scores={})), other)
    weights_of(other).replace(weights_of(kept))
    assert "it was changed" in refusal(kept)
    assert "other.safetensors is no file" in refusal(other)
    description_of(kept).unlink()
    assert "knee-0.2.json is no file" in refusal(kept)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.99])
def test_cut_files_are_refused(kept, share):
    whole = weights_of(kept).read_bytes()
    weights_of(kept).write_bytes(whole[: int(share * len(whole))])
    assert "it was changed" in refusal(kept)
    weights_of(kept).write_bytes(whole)
    text = description_of(kept).read_bytes()
    description_of(kept).write_bytes(text[: int(share * len(text))])
    assert "must be JSON" in refusal(kept)


def test_weights_of_no_or_another_form_are_refused(tmp_path):
    """With the digest that fits: a zip, a pickle, headers that lie."""
    honest = save(tensors())
    size = int.from_bytes(honest[:8], "little")
    lying = honest[8 : 8 + size].replace(b'"data_offsets":[0,', b'"data_offsets":[9,', 1)
    for content in (
        b"",
        b"PK\x03\x04" + bytes(100),
        pickle.dumps({"a": 1}),
        (2**63).to_bytes(8, "little") + honest[8:],
        honest[:8] + lying + honest[8 + size :],
        honest[:-1],
        honest + b"\0",
    ):
        weights_of(tmp_path / "p").write_bytes(content)
        told = {**described(), "sha256": sha256(content).hexdigest()}
        description_of(tmp_path / "p").write_text(json.dumps(told), encoding="utf-8")
        assert "must be of safetensors' form" in refusal(tmp_path / "p")


@pytest.mark.parametrize("metadata", ["null", "{}", '{"description_sha256":"0"}'])
def test_weights_that_do_not_say_what_describes_them_are_refused(tmp_path, metadata):
    header = json.dumps({"__metadata__": 0, "0.bias": {"dtype": "F32", "shape": [3], "data_offsets": [0, 12]}})
    header = header.replace("0", metadata, 1)
    content = len(header).to_bytes(8, "little") + header.encode() + bytes(12)
    weights_of(tmp_path / "p").write_bytes(content)
    told = {**described(), "sha256": sha256(content).hexdigest()}
    description_of(tmp_path / "p").write_text(json.dumps(told), encoding="utf-8")
    assert "it was changed" in refusal(tmp_path / "p")


@pytest.mark.parametrize(
    "text", ["", "[]", "3", '{"a": NaN}', "\xff", "[" * 100_000, '{"format": "stickslip policy 1"}', "{" + '"a":' * 9]
)
def test_descriptions_of_another_form_are_refused(kept, text):
    description_of(kept).write_bytes(text.encode("latin-1"))
    message = refusal(kept)
    assert ("must be JSON: numbers must be finite, got NaN" in message) == ("NaN" in text)


def test_what_is_too_large_is_not_read(kept):
    text = description_of(kept).read_text(encoding="utf-8")
    size = len(text.encode())
    description_of(kept).write_text(text + " " * (2**20 - size), encoding="utf-8")
    assert read_policy(kept).description == described()
    description_of(kept).write_text(text + " " * (2**20 - size + 1), encoding="utf-8")
    assert "must have at most 1048576 bytes" in refusal(kept)
    description_of(kept).write_text(text, encoding="utf-8")
    with weights_of(kept).open("ab") as file:
        file.truncate(16 * 2**20 + 1)
    assert "must have at most 16777216 bytes" in refusal(kept)


def test_what_cannot_be_written_leaves_the_old_files(kept, monkeypatch):
    before = {file.name: file.read_bytes() for file in kept.parent.iterdir()}

    def fail(*_):
        raise OSError("no space")

    monkeypatch.setattr("pathlib.Path.write_bytes", fail)
    with pytest.raises(OSError, match="no space"):
        write_policy(Policy(layers(), described(scores={})), kept)
    assert {file.name: file.read_bytes() for file in kept.parent.iterdir()} == before
