"""One odd value in a file: it is refused in a sentence, or the file loads; nothing else happens."""

import pytest
from hypothesis import HealthCheck, given, settings
from references.odd_values import odd_documents

from jaxatt import scenarios
from jaxatt.scenarios import ScenarioError

EXAMPLES = settings(
    derandomize=True,
    database=None,
    deadline=None,
    max_examples=300,
    suppress_health_check=list(HealthCheck),
)


def refused_or_loaded(read, odd):
    name, path, value, document = odd
    try:
        read(document, origin="odd.toml")
    except ScenarioError as error:
        named = path == ("vehicle", "file")  # the message is then about the file named
        for message in str(error).splitlines():
            assert named or message.startswith("odd.toml: "), message
            assert "; " in message, f"no mend in: {message}"
            assert len(message) < 1000, f"{name} {path} {value!r:.40}: {message:.200}"


@EXAMPLES
@given(odd_documents(scenarios.names("manoeuvre")))
def test_any_odd_value_of_a_manoeuvre(odd):
    refused_or_loaded(scenarios.from_mapping, odd)


@EXAMPLES
@given(odd_documents(scenarios.names("flight")))
def test_any_odd_value_of_a_flight(odd):
    refused_or_loaded(scenarios.flight_from_mapping, odd)


@pytest.mark.parametrize(
    ("content", "part"),
    [
        ("intervals = " + "9" * 5000, "too many digits"),
        ("a = " + "[" * 2000, "nested more than 50 deep"),
        ("[" + ".".join("a" * 200) + "]", "nested more than 50 deep"),
        ("[horizon]\n" * 2, "not valid TOML"),
    ],
)
def test_texts_that_no_reader_follows(tmp_path, content, part):
    path = tmp_path / "odd.toml"
    path.write_text(content)
    with pytest.raises(ScenarioError, match=part):
        scenarios.load(path)


@pytest.mark.parametrize("name", ["a\0b.toml", "a\0b", "x" * 300, "x" * 300 + ".toml", "a/" * 3000])
def test_names_of_files_that_no_system_has(name):
    for load in (scenarios.load, scenarios.load_flight, scenarios.load_file):
        with pytest.raises(ScenarioError):
            load(name)
    document = {**scenarios.load("hypso1-90-45-15").document, "vehicle": {"file": name}}
    with pytest.raises(ScenarioError):
        scenarios.from_mapping(document)
