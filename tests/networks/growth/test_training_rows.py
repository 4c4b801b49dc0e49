import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from polydraulic import AbductiveRegressor
from polydraulic.networks.growth.training_rows import ParquetBlocks, rows_from_blocks, rows_in_memory, sample_of

RNG = np.random.default_rng(0)
X = RNG.uniform(-1.0, 1.0, size=(900, 3)) * [1.0, 100.0, 1e-3] + [0.0, 1e4, 0.0]
Y = np.exp(X[:, 0]) * np.sin(X[:, 1] / 30.0) + X[:, 2] * 1e3
W = RNG.integers(0, 3, 900).astype(float)
CUTS = (100, 101, 640)


def in_blocks(*arrays):
    return list(zip(*(np.split(a, CUTS) for a in arrays), strict=True))


def test_statistics_of_blocks_are_those_of_all_rows():
    whole, parts = rows_in_memory(X, Y, W).scaling, rows_from_blocks(in_blocks(X, Y, W)).scaling
    used = W > 0
    assert parts.x_mean == pytest.approx(np.average(X, axis=0, weights=W), rel=1e-13)
    variance = np.average((X - parts.x_mean) ** 2, axis=0, weights=W)
    assert parts.x_scale == pytest.approx(np.sqrt(variance), rel=1e-12)
    assert parts.x_low == pytest.approx(X[used].min(axis=0))
    assert parts.y_mean == pytest.approx(whole.y_mean, rel=1e-12)


@pytest.mark.parametrize("weighted", [False, True])
def test_a_fit_in_blocks_is_the_fit_in_one_piece(weighted):
    settings = {"max_layers": 2, "n_survivors": 4}
    whole = AbductiveRegressor(**settings).fit(X, Y, W if weighted else None)
    blocks = in_blocks(X, Y, W) if weighted else in_blocks(X, Y)
    parts = AbductiveRegressor(**settings).fit_blocks(blocks)
    assert parts.predict(X) == pytest.approx(whole.predict(X), abs=1e-9 * np.ptp(Y))
    assert parts.pse_ == pytest.approx(whole.pse_, rel=1e-6)


def test_parquet_row_groups_are_blocks(tmp_path):
    table = pa.table({"a": X[:, 0], "b": X[:, 1], "c": X[:, 2], "y": Y, "w": W})
    pq.write_table(table, tmp_path / "t.parquet", row_group_size=250)
    blocks = ParquetBlocks(tmp_path / "t.parquet", ["a", "b", "c"], "y", "w")
    assert [len(block[1]) for block in blocks] == [250, 250, 250, 150]
    from_file = AbductiveRegressor(max_layers=1).fit_blocks(blocks)
    in_memory = AbductiveRegressor(max_layers=1).fit(X, Y, W)
    assert from_file.predict(X) == pytest.approx(in_memory.predict(X), abs=1e-9 * np.ptp(Y))
    with pytest.raises(ValueError, match=r"no column 'z'; the file has \['a', 'b', 'c', 'y', 'w'\]"):
        AbductiveRegressor().fit_blocks(ParquetBlocks(tmp_path / "t.parquet", ["z"], "y"))


@pytest.mark.parametrize(
    ("blocks", "message"),
    [
        (iter([(X, Y)]), "can be read only once"),
        ([], "no rows to learn from"),
        ([(X, Y[:5])], "block 0: X .* must be"),
        ([(X, Y), (X[:, :2], Y)], "a block has 2 inputs, those before it have 3"),
        ([(X, np.where(Y > 1, np.nan, Y))], "block 0: every value must be finite"),
        ([(X, Y, -W)], "weights not negative"),
        ([(X[:3], Y[:3])], "at least 4 rows"),
    ],
)
def test_bad_blocks_are_named(blocks, message):
    with pytest.raises(ValueError, match=message):
        AbductiveRegressor().fit_blocks(blocks)


def test_blocks_offer_no_calibration():
    with pytest.raises(ValueError, match="fit_blocks takes"):
        AbductiveRegressor(calibration=0.2).fit_blocks([(X, Y)])


def test_a_sample_has_rows_from_all_over_and_the_scaling_of_all():
    X = np.arange(1000.0)[:, None]
    rows = rows_from_blocks([(X[:300], 2.0 * X[:300, 0]), (X[300:], 2.0 * X[300:, 0])])
    sample = sample_of(rows, 50)
    drawn = np.concatenate([x[:, 0] for x, _, _ in sample.blocks()])
    assert np.array_equal(drawn // 20, np.arange(50))  # one of each stretch of twenty
    assert len(set((drawn % 20).tolist())) > 10
    assert np.array_equal(np.concatenate([y for _, y, _ in sample.blocks()]), 2.0 * drawn)
    assert sample.scaling == rows.scaling._replace(weight=50.0, n_row=50)
    assert sample_of(rows, 1000) is rows


def test_a_sample_keeps_weights():
    weight = np.linspace(1.0, 2.0, 100)
    sample = sample_of(rows_in_memory(weight[:, None], weight, weight), 10)
    ((x, _, w),) = sample.blocks()
    assert np.array_equal(x[:, 0], w)
    assert sample.scaling.weight == w.sum()
