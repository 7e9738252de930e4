"""Plays a USD file with Pixar's UsdSkel: says what the layer states, and where all points of all meshes are.

    python check.py FILE.usda FRAME…

Prints one JSON object: what the stage says of itself, what is wrong with it, and under `frames` the points of each mesh
(in the order of the file) at each of the frames, blend shapes and skinning applied.
"""

import json
import sys

from pxr import Gf, Usd, UsdGeom, UsdSkel, UsdUtils


def faults(path):
    """What Pixar's own checker finds, where this version of USD has one."""
    if hasattr(UsdUtils, "ComplianceChecker"):
        checker = UsdUtils.ComplianceChecker(skipARKitRootLayerCheck=True)
        checker.CheckCompliance(path)
        return checker.GetErrors() + checker.GetFailedChecks()
    from pxr import UsdValidation

    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    errors = context.Validate(Usd.Stage.Open(path))
    return [error.GetErrorAsString() for error in errors if error.GetType() != UsdValidation.ValidationErrorType.Info]


def main(path, frames):
    found = faults(path)
    stage = Usd.Stage.Open(path)
    root = UsdSkel.Root(stage.GetDefaultPrim())
    skeleton = next(UsdSkel.Skeleton(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))
    animation = next(UsdSkel.Animation(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Animation))
    said = {
        "metersPerUnit": UsdGeom.GetStageMetersPerUnit(stage),
        "upAxis": UsdGeom.GetStageUpAxis(stage),
        "timeCodesPerSecond": stage.GetTimeCodesPerSecond(),
        "startTimeCode": stage.GetStartTimeCode(),
        "endTimeCode": stage.GetEndTimeCode(),
        "provenance": stage.GetRootLayer().customLayerData,
        "joints": list(skeleton.GetJointsAttr().Get()),
        "blendShapes": list(animation.GetBlendShapesAttr().Get() or []),
        "keys": animation.GetBlendShapeWeightsAttr().GetNumTimeSamples(),
        "faults": found,
    }
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    said["meshes"] = [mesh.GetPrim().GetName() for mesh in meshes]
    # Baking writes points that are posed as any viewer poses them; only the wanted frames are baked.
    said["frames"] = {}
    for frame in frames:
        if not UsdSkel.BakeSkinning(root, Gf.Interval(frame)):
            sys.exit(f"frame {frame} cannot be baked")
        said["frames"][str(frame)] = [[list(p) for p in mesh.GetPointsAttr().Get(frame)] for mesh in meshes]
        stage.Reload()
        stage.GetRootLayer().Reload(True)
    json.dump(said, sys.stdout)


main(sys.argv[1], [int(frame) for frame in sys.argv[2:]])
