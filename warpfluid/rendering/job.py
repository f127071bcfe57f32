"""One picture after another of volumes: read a frame, light it, take the picture, write it."""

import time
from dataclasses import dataclass, field, replace

from warpfluid.device import one_blas_thread
from warpfluid.errors import writing
from warpfluid.options import CameraOptions
from warpfluid.rendering.framing import cameras, picture_size
from warpfluid.rendering.output import Target
from warpfluid.rendering.picture import Picture
from warpfluid.rendering.shots import Shot
from warpfluid.rendering.studio import Studio
from warpfluid.volumes import VolumeSequence

BYTES_A_VOXEL = 48  # of light, shadows and bricks; measured
BYTES_A_FIELD = 8  # and voxel: as it is read, and on the device
BYTES_A_PIXEL = 120


@dataclass
class PictureJob:
    """Makes pictures; it can be sent to another process.

    Attributes:
        volumes: What is shown.
        camera: Where from.
        studio: Takes the pictures.
        target: Where they go.
        outlines: What stands in the run, if that is drawn.
    """

    volumes: VolumeSequence
    camera: CameraOptions
    studio: Studio
    target: Target
    outlines: object | None = None
    _frame: int | None = None
    _fields: dict = field(default_factory=dict)

    def __getstate__(self) -> dict:
        """Return what another process needs; it has a device of its own."""
        return self.__dict__ | {"studio": replace(self.studio, device="", _last=[]), "_frame": None, "_fields": {}}

    @property
    def voxel_size(self) -> float:
        """Edge of a voxel in units of the scene."""
        lattice = self.volumes.lattice
        return lattice.voxel_size if lattice else self.volumes.output.voxel_size

    @one_blas_thread()
    def __call__(self, shot: Shot, device, progress) -> dict:
        """Make a picture and write it, unless it is one of a film.

        Args:
            shot: Which one.
            device: Where to make it.
            progress: Not called: a picture has no iterations.

        Returns:
            Its record; of a film ``screen``, uint8 (rows, columns, 3).

        Raises:
            ValueError: If it cannot be made.
            OSError: If its volume cannot be read.
            CannotWriteError: If it cannot be written.
        """
        begin = time.perf_counter()
        if str(self.studio.device) != str(device):
            self.studio = replace(self.studio, device=device, _last=[])
        eyes = self._eyes(shot)
        record = {"picture": shot.number, "frame": shot.frame}
        if self.target.is_film:
            record["screen"] = self.target.screen(shot.number, eyes, self.studio.screen)
            return record | {"file": self.target.path.name, "seconds": round(time.perf_counter() - begin, 3)}
        with writing(self.target.path):
            files = self.target.write(shot.number, eyes, self.studio.screen, self.voxel_size)
        names = ", ".join(file.name for file in files)
        return record | {"file": names, "seconds": round(time.perf_counter() - begin, 3)}

    def need(self, shape: tuple[int, int, int], fields: int) -> int:
        """Return the memory of a picture [byte].

        Args:
            shape: Of the volumes.
            fields: How many are shown.
        """
        width, height = picture_size(shape, self.studio.options.size())
        voxels = shape[0] * shape[1] * shape[2]
        return voxels * (BYTES_A_VOXEL + fields * BYTES_A_FIELD) + width * height * BYTES_A_PIXEL

    def _eyes(self, shot: Shot) -> list[Picture]:
        """Return the picture of a shot, or those of both eyes."""
        if shot.frame != self._frame:
            self._frame, self._fields = None, {}  # two frames at once are one too many
            self._fields = self.volumes.fields(shot.frame, self.studio.names)
            self._frame = shot.frame
        lit = self.studio.light(self._fields, shot.number)
        shape = self._fields["density"].shape
        size = picture_size(shape, self.studio.options.size())
        solids = self.outlines.at(shot.frame, shape) if self.outlines else ()
        views = cameras(self.camera, shape, size, shot.number, shot.turned)
        return [self.studio.shoot(lit, view, shot.number, solids) for view in views]
