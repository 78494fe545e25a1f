"""What goes wrong while it works, where a broken one cannot even be imported."""


def rule(scene, deviation):
    raise ValueError(f"no rule\nfor {len(scene.names)} objects")


def orderer(situation, targets, **_):
    return list(targets)
