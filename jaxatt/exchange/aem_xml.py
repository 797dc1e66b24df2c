"""Write attitudes as a CCSDS Attitude Ephemeris Message (AEM) in XML, version 2."""

from __future__ import annotations

import numpy as np

from jaxatt.exchange.aem import header, metadata, scalar_last
from jaxatt.exchange.moments import instants, written
from jaxatt.exchange.motion import AttitudeHistory, Named

_SCHEMA = "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd"
_QUATERNION = ("Q1", "Q2", "Q3", "QC")
_RATE = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")


def aem_xml(histories: list[AttitudeHistory], named: Named) -> str:
    """AEM of one or more spans of time, as `aem.aem_text`."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<aem xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"',
        f'     xsi:noNamespaceSchemaLocation="{_SCHEMA}"',
        '     id="CCSDS_AEM_VERS" version="2.0">',
        "  <header>",
        *(f"    {_element(*line.split(' = '))}" for line in header(named)),
        "  </header>",
        "  <body>",
    ]
    for history in histories:
        stamps = written(instants(history.epoch, history.time))
        lines += ["    <segment>", "      <metadata>"]
        lines += [f"        {_element(key, text)}" for key, text in metadata(stamps, named, 2)]
        lines += ["      </metadata>", "      <data>"]
        rates = np.degrees(history.omega_ib)
        for stamp, q, rate in zip(stamps, scalar_last(history.q_ib), rates, strict=True):
            numbers = "".join(
                _element(key, f"{x:.15f}") for key, x in zip(_QUATERNION, q, strict=True)
            )
            turning = "".join(
                f'<{key} units="deg/s">{x:.15e}</{key}>' for key, x in zip(_RATE, rate, strict=True)
            )
            lines.append(
                f"        <attitudeState><quaternionAngVel>{_element('EPOCH', stamp)}"
                f"<quaternion>{numbers}</quaternion><angVel>{turning}</angVel>"
                "</quaternionAngVel></attitudeState>"
            )
        lines += ["      </data>", "    </segment>"]
    lines += ["  </body>", "</aem>"]
    return "\n".join(lines) + "\n"


def _element(key: str, text: str) -> str:
    safe = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return f"<{key}>{safe}</{key}>"
