"""Pack the sample recordings into the wheel, so that `shakerproc demo` has them there too."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

SAMPLES = Path(__file__).parent / "sample_data"
PACKED = ("testlog.yaml", "model.yaml", "recordings")


class BuildWithSamples(build_py):
    """Copies what the demo processes beside the modules."""

    def run(self) -> None:
        """Build the package, then add the samples; a checkout has them already."""
        super().run()
        if self.editable_mode:
            return
        target = Path(self.build_lib) / "shakerproc" / "sample_data"
        for name in PACKED:
            source = SAMPLES / name
            if source.is_dir():
                shutil.copytree(source, target / name, dirs_exist_ok=True)
            else:
                target.mkdir(parents=True, exist_ok=True)
                shutil.copy2(source, target / name)


setup(cmdclass={"build_py": BuildWithSamples})
