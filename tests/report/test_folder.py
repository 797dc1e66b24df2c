"""Summary, archive and figures of a result in one folder."""


def test_everything_in_one_folder(make, tmp_path):
    written = make("double-integrator").save(tmp_path / "out")
    assert {path.name for path in written} == {
        "summary.json",
        "result.nc",
        "overview.png",
        "control.png",
        "state.png",
        "starts.png",
    }
    assert set((tmp_path / "out").iterdir()) == set(written)
