"""The photo of a specimen, encoded anew so that nothing but its picture comes into the page."""

import base64
import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Final

from shakerproc.errors import LogError

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

FORMATS: Final = ("JPEG", "PNG", "WEBP", "TIFF", "BMP")
"""What is read."""

SIDE: Final = 1200
"""Longest side in the page [px]: sharp on half a page of A4."""

QUALITY: Final = 82
"""Of the JPEG in the page."""


def photo_uri(path: Path) -> str:
    """Return a photo as a data URI: turned upright, at most `SIDE` large, without metadata.

    Raises
    ------
    LogError
        If it is no picture that can be read, or too large a one.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        with warnings.catch_warnings(), _opened(path) as picture:
            picture.draft("RGB", (2 * SIDE, 2 * SIDE))
            upright = ImageOps.exif_transpose(picture)
            upright.thumbnail((SIDE, SIDE))
            flat = Image.new("RGB", upright.size, "white")
            layer = upright.convert("RGBA")
            flat.paste(layer, mask=layer.getchannel("A"))
    except (Image.DecompressionBombWarning, Image.DecompressionBombError) as error:
        most = (Image.MAX_IMAGE_PIXELS or 0) / 1e6
        raise LogError(
            f"{path}: the photo has more than {most:.0f} million pixels; save it smaller"
        ) from error
    except (UnidentifiedImageError, SyntaxError) as error:
        raise LogError(f"{path}: {_NO_PICTURE}") from error
    except (OSError, ValueError, EOFError) as error:
        raise LogError(f"{path}: {_NO_PICTURE} ({error})") from error
    content = io.BytesIO()
    flat.save(content, "JPEG", quality=QUALITY)
    return f"data:image/jpeg;base64,{base64.b64encode(content.getvalue()).decode()}"


def _opened(path: Path) -> "ImageFile":
    """Return a picture that is opened, if it does not unfold to more than Pillow deems safe."""
    from PIL import Image

    warnings.simplefilter("error", Image.DecompressionBombWarning)
    return Image.open(path, formats=FORMATS)


_NO_PICTURE: Final = f"no photo that can be read; save it as one of {', '.join(FORMATS)}"
