"""Orbit Mean-Elements Messages in every form, against the two lines that say the same."""

import csv
import io
import json

import numpy as np
import pytest
from references.public_orbits import HYPSO1, REPORT
from sgp4.exporter import export_omm

from jaxatt.environment.orbit_data.formats import kind_of
from jaxatt.environment.orbit_data.omm import read_omm
from jaxatt.environment.orbit_data.path import OrbitDataError
from jaxatt.environment.orbit_data.tle import element_set


def fields(lines, **changes):
    """The message of two lines, as `sgp4` exports it."""
    found = export_omm(element_set(lines).satrec, "A SATELLITE")
    return {key: value for key, value in {**found, **changes}.items() if value is not None}


def as_json(*messages):
    return json.dumps(messages)


def as_csv(*messages):
    text = io.StringIO()
    writer = csv.DictWriter(text, list(messages[0]))
    writer.writeheader()
    writer.writerows(messages)
    return text.getvalue()


def as_kvn(message):
    units = {"INCLINATION": " [deg]", "MEAN_MOTION": " [rev/day]"}
    rows = [f"{key:20} = {value}{units.get(key, '')}" for key, value in message.items()]
    return "\n".join(["CCSDS_OMM_VERS = 2.0", "COMMENT of nobody", *rows])


ABOUT = ("OBJECT_", "CENTER", "REF_", "TIME_", "MEAN_ELEMENT_")


def as_xml(*messages):
    def leaves(message, chosen):
        return "".join(f"<{k}>{v}</{k}>" for k, v in message.items() if chosen(k))

    parts = []
    for message in messages:
        inner = leaves(message, lambda key: key.startswith(ABOUT))
        rest = leaves(message, lambda key: not key.startswith(ABOUT))
        parts.append(
            f'<omm id="CCSDS_OMM_VERS" version="2.0"><header/><body><segment><metadata>{inner}'
            f"</metadata><data><meanElements>{rest}</meanElements></data></segment></body></omm>"
        )
    return f'<?xml version="1.0"?>\n<ndm>{"".join(parts)}</ndm>'


@pytest.mark.parametrize("form", [as_json, as_csv, as_kvn, as_xml])
@pytest.mark.parametrize("lines", [HYPSO1, *REPORT])
def test_every_form_is_the_orbit_of_the_two_lines(form, lines):
    text = form(fields(lines))
    assert kind_of(text) == "omm"
    (found,) = read_omm(text)
    expected = element_set(lines)
    assert found.name == "A SATELLITE" and int(found.number) == int(expected.number)
    assert found.epoch == pytest.approx(expected.epoch, abs=1e-9)
    times = np.random.default_rng(5).uniform(0.0, 86400.0, 20)
    r, v = found.over(found.epoch, 0.0, 86400.0)(times)
    r_too, v_too = expected.over(expected.epoch, 0.0, 86400.0)(times)
    # The message has the epoch to a microsecond, in which a satellite flies 8 mm.
    np.testing.assert_allclose(r, r_too, rtol=0.0, atol=0.05)
    np.testing.assert_allclose(v, v_too, rtol=0.0, atol=5e-5)


@pytest.mark.parametrize("form", [as_json, as_csv, as_xml])
def test_several_messages_of_one_text(form):
    found = read_omm(form(fields(HYPSO1), fields(REPORT[0])))
    assert [int(s.number) for s in found] == [51053, 5]


def test_long_numbers_and_epochs_without_a_fraction():
    (found,) = read_omm(
        as_json(fields(HYPSO1, NORAD_CAT_ID="123456789", EPOCH="2025-09-07T22:41:17"))
    )
    assert found.number == "123456789"
    assert found.epoch == pytest.approx(element_set(HYPSO1).epoch, abs=1e-5)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"REF_FRAME": "EME2000"}, "REF_FRAME is EME2000, .*TEME"),
        ({"MEAN_ELEMENT_THEORY": "DSST"}, "MEAN_ELEMENT_THEORY is DSST"),
        ({"CENTER_NAME": "MOON"}, "CENTER_NAME is MOON"),
        ({"MEAN_MOTION": None}, "MEAN_MOTION is missing"),
        ({"ECCENTRICITY": "much"}, "could not convert"),
        ({"EPOCH": "yesterday"}, "yesterday"),
    ],
)
def test_what_cannot_be_propagated_is_refused(changes, said):
    with pytest.raises(OrbitDataError, match=said) as caught:
        read_omm(as_json(fields(HYPSO1, **changes)))
    assert "; " in str(caught.value)


@pytest.mark.parametrize("text", ["[1, 2]", '{"MEAN_MOTION":', "<omm><body></omm>", "[]"])
def test_broken_texts_are_refused(text):
    with pytest.raises(OrbitDataError):
        read_omm(text)
