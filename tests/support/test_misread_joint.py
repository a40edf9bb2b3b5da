"""Where a joint's encoder is known to read wrongly, bands run where the links are, not where it says."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.devices.routing import Routing
from exogauge.effects.catalogue import missing_effects
from exogauge.identification.model import AddedEffect, AxisSizes, Extension
from exogauge.identification.per_log import PerLog
from exogauge.identification.predict import Parameters
from exogauge.identification.sites import EncoderSite
from exogauge.support.evaluate import estimate_support
from exogauge.support.settings import PlainLog, WornLog

SIZES = {"encoder_zero": [0.05], "encoder_eccentricity": [0.03, -0.02, 0.01, 0.0]}


def misread(q, name):
    """What the encoder says where the joint stands at q."""
    read = q
    for _ in range(60):
        waves = np.stack([np.sin(read), np.cos(read), np.sin(2.0 * read), np.cos(2.0 * read)])
        read = q - (SIZES[name] @ waves if name == "encoder_eccentricity" else SIZES[name][0])
    return read


@pytest.mark.slow
@pytest.mark.parametrize("name", SIZES)
def test_bands_run_where_the_links_are(biped, suit, stoop, inner, name):
    joint = biped.torso[1]
    effect = next(each for each in missing_effects() if each.name == name)
    known, sizes = biped.known(), AxisSizes(*(np.ones(len(biped.robot.joints)) for _ in range(4)))
    parent = replace(known, sizes=sizes, order={}, computed=PerLog())
    extension = Extension(parent, (AddedEffect(effect, EncoderSite(joint)),))
    own, makers = (Parameters(each.phi, each.xi, np.array(SIZES[name])) for each in (known.identified, known.a_priori))
    equations = replace(known.equations, added=extension.columns)
    nothing = np.zeros((equations.size, equations.size))
    model = replace(parent, equations=equations, identified=own, a_priori=makers, extension=extension,
                    covariance=nothing, a_priori_covariance=nothing)  # fmt: skip

    def log(seed, name_of_log, bands=()):
        made = biped.record(stoop(seed), name_of_log, bands).log
        channel = f"q.{biped.robot.joints[joint].name}"
        return replace(made, channels={**made.channels, channel: misread(made.channels[channel], name)})

    plain, worn = log(0, "plain"), log(1, "worn", suit.bands)
    asked = [PlainLog(plain, "stoop", True)], [WornLog(worn, "stoop", suit)]
    found, blind = (estimate_support(each, *asked)[0].trials[0] for each in (model, known))
    routing = Routing(biped.robot.tree, suit.bands)
    for k, band in enumerate(suit.bands):
        true = routing.lengths(stoop(1).q)[inner, k]
        off = np.abs(blind.length[band.name][inner] - true).max()
        assert off > 1e-3
        assert np.abs(found.length[band.name][inner] - true).max() < 0.02 * off
