"""Makes the files of this folder with GDAL, SciPy, netCDF4, OpenEXR and Pillow: none is written by Relief.

    pip install numpy rasterio scipy netCDF4 OpenEXR pillow
    python tests/data/formats/make.py

The samples follow the formulas of `value` below, which tests/formats.rs computes, too.
"""

import gzip
import shutil
from pathlib import Path

import netCDF4
import numpy as np
import OpenEXR
import rasterio
import scipy.io
from PIL import Image
from rasterio.shutil import copy
from rasterio.transform import Affine

HERE = Path(__file__).parent
W, H = 21, 18
TYPES = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"]


def value(kind, column, row):
    """The sample of a type: exact in it, negative where it can be, with all its bytes in use."""
    n = 7 * column + 5 * row * row + column * row
    if kind == "uint8":
        return n % 251
    if kind == "int8":
        return n % 251 - 125
    if kind == "uint16":
        return 200 + 31 * n
    if kind == "int16":
        return 17 * n - 9000
    if kind == "uint32":
        return 3_000_000_000 + 70_001 * n
    if kind == "int32":
        return 70_001 * n - 60_000_000
    if kind == "float32":
        return n * 0.25 - 100.5
    return n / 3.0 - 100.0


def grid(kind, width=W, height=H):
    return np.array([[value(kind, c, r) for c in range(width)] for r in range(height)], dtype=kind)


# 30 m in UTM zone 11 north.
UTM = Affine(30.0, 0.0, 400000.0, 0.0, -30.0, 4000000.0)


def write(name, data, transform=UTM, crs="EPSG:32611", nodata=None, tags=None, band_tags=None, **options):
    path = HERE / name
    path.parent.mkdir(parents=True, exist_ok=True)
    bands = data if data.ndim == 3 else data[None]
    profile = dict(driver="GTiff", width=bands.shape[2], height=bands.shape[1], count=bands.shape[0],
                   dtype=bands.dtype.name, crs=crs, transform=transform, nodata=nodata)
    profile.update(options)
    with rasterio.open(path, "w", **profile) as file:
        file.write(bands)
        if tags:
            file.update_tags(**tags)
        if band_tags:
            file.scales, file.offsets = band_tags
    return path


def tiffs():
    """Every type × compression × predictor × layout that GDAL writes."""
    for kind in TYPES:
        for compression in ["NONE", "LZW", "DEFLATE", "PACKBITS", "ZSTD"]:
            predictors = [1]
            if compression in ("LZW", "DEFLATE", "ZSTD"):
                predictors += [2] + ([3] if kind.startswith("float") else [])
            for predictor in predictors:
                for layout in ["strips", "tiles"]:
                    options = dict(compress=compression, predictor=predictor)
                    if layout == "tiles":
                        options.update(tiled=True, blockxsize=16, blockysize=16)
                    else:
                        options.update(blockysize=7)
                    if predictor == 1:
                        del options["predictor"]
                    name = f"tiff/{kind}-{compression.lower()}-p{predictor}-{layout}.tif"
                    # GDAL writes this transformation, whose rows run north; without a system it is no place.
                    write(name, grid(kind), crs=None, transform=Affine.identity(), **options)
    data = grid("int16")
    write("special/bigtiff.tif", data, BIGTIFF="YES", compress="LZW", tiled=True, blockxsize=16, blockysize=16)
    write("special/big-endian.tif", data, ENDIANNESS="BIG", compress="DEFLATE", predictor=2)
    write("special/nodata.tif", np.where(data == value("int16", 3, 4), -9999, data).astype("int16"), nodata=-9999)
    holes = grid("float32")
    holes[5:9, 6:10] = np.nan
    write("special/nan.tif", holes, nodata=float("nan"))
    write("special/degrees.tif", data, Affine(0.01, 0, -120.0, 0, -0.01, 36.0), "EPSG:4326")
    write("special/mercator.tif", data, Affine(1000.0, 0, -12500000.0, 0, -1000.0, 4323000.0), "EPSG:3857")
    write("special/feet.tif", data, Affine(100.0, 0, 980000.0, 0, -100.0, 200000.0), "EPSG:2263")
    write("special/point.tif", data, tags={"AREA_OR_POINT": "Point"})
    write("special/south-up.tif", data[::-1], Affine(30.0, 0, 400000.0, 0, 30.0, 4000000.0 - 30.0 * H))
    write("special/rotated.tif", data, UTM * Affine.rotation(30))
    write("special/bands.tif", np.stack([data, data + 1000, data + 2000]), INTERLEAVE="PIXEL")
    write("special/planes.tif", np.stack([data, data + 1000, data + 2000]), INTERLEAVE="BAND", tiled=True,
          blockxsize=16, blockysize=16, compress="LZW")
    write("special/scaled.tif", data, band_tags=((0.5,), (100.0,)))
    write("special/sixteen-bit-floats.tif", (grid("float32") / 4).astype("float32"), NBITS="16")
    # A tile that was never written has no bytes.
    path = HERE / "special/sparse.tif"
    with rasterio.open(path, "w", driver="GTiff", width=40, height=36, count=1, dtype="int16", crs="EPSG:32611",
                       transform=UTM, SPARSE_OK=True, tiled=True, blockxsize=16, blockysize=16, compress="DEFLATE") as file:
        file.write(grid("int16", 16, 16), 1, window=((16, 32), (16, 32)))
    copy(HERE / "special/bigtiff.tif", HERE / "special/cog.tif", driver="COG", compress="DEFLATE", blocksize=128)
    write("special/complex.tif", data.astype("complex64"))
    write("special/palette.tif", grid("uint8"), photometric="PALETTE")
    write("special/jpeg.tif", grid("uint8"), compress="JPEG", tiled=True, blockxsize=16, blockysize=16)
    try:
        write("special/lerc.tif", grid("float32"), compress="LERC")
    except rasterio.errors.RasterioError as error:
        print("no LERC:", error)


def rasters():
    """ESRI's formats, USGS DEM and Terragen, through GDAL's own writers."""
    source = write("tmp/source.tif", grid("int16"), nodata=-9999)
    floats = write("tmp/floats.tif", grid("float32"))
    (HERE / "other").mkdir(exist_ok=True)
    copy(source, HERE / "other/grid.asc", driver="AAIGrid")
    copy(floats, HERE / "other/floats.asc", driver="AAIGrid", FORCE_CELLSIZE="YES", SIGNIFICANT_DIGITS=9)
    copy(source, HERE / "other/grid.bil", driver="EHdr")
    copy(floats, HERE / "other/floats.flt", driver="EHdr")
    bands = write("tmp/bands.tif", np.stack([grid("uint8"), grid("uint8")[::-1]]))
    copy(bands, HERE / "other/bands.bil", driver="EHdr")
    metric = write("tmp/metric.tif", ((grid("int16") + 9000) // 4).astype("float32"))
    copy(metric, HERE / "other/terrain.ter", driver="Terragen", MINUSERPIXELVALUE=0, MAXUSERPIXELVALUE=12000)
    # 10 m in UTM, whole metres: what the USGS format can say.
    dem = write("tmp/dem.tif", grid("int16"), Affine(30.0, 0, 399985.0, 0, -30.0, 4000015.0), "EPSG:26911", nodata=-32767)
    copy(dem, HERE / "other/profile.dem", driver="USGSDEM", ZRESOLUTION=1.0)
    # A tile of one degree; most of it is one height, so that it packs well.
    tile = np.full((1201, 1201), 100, dtype="int16")
    tile[:H, :W] = grid("int16")
    tile[600, 600] = -32768
    step = 1.0 / 1200.0
    tile = write("tmp/tile.tif", tile, Affine(step, 0, -113 - step / 2, 0, -step, 37 + step / 2), "EPSG:4326", nodata=-32768)
    copy(tile, HERE / "tmp/N36W113.hgt", driver="SRTMHGT")
    with open(HERE / "tmp/N36W113.hgt", "rb") as plain, open(HERE / "other/N36W113.hgt.gz", "wb") as packed:
        packed.write(gzip.compress(plain.read(), 9, mtime=0))


def netcdfs():
    latitude, longitude = 36.0 + 0.1 * np.arange(H), -120.0 + 0.1 * np.arange(W)
    for name, kind in [("classic", 1), ("offset64", 2)]:
        with scipy.io.netcdf_file(HERE / f"other/{name}.nc", "w", version=kind) as file:
            file.createDimension("lat", H)
            file.createDimension("lon", W)
            for axis, values, unit in [("lat", latitude, "degrees_north"), ("lon", longitude, "degrees_east")]:
                variable = file.createVariable(axis, "f8", (axis,))
                variable[:] = values
                variable.units = unit
            heights = file.createVariable("elevation", "i2", ("lat", "lon"))
            data = grid("int16").copy()
            data[2, 3] = -32767
            # Ascending latitude: the first row is the southernmost.
            heights[:] = data[::-1]
            heights._FillValue = np.int16(-32767)
            heights.units = "m"
    with netCDF4.Dataset(HERE / "other/packed.nc", "w", format="NETCDF3_CLASSIC") as file:
        file.createDimension("time", None)
        file.createDimension("y", H)
        file.createDimension("x", W)
        for axis, count in [("y", H), ("x", W)]:
            variable = file.createVariable(axis, "f4", (axis,))
            variable.units = "m"
            variable[:] = 90.0 * (count - 1 - np.arange(count) if axis == "y" else np.arange(count))
        other = file.createVariable("slope", "f4", ("time", "y", "x"))
        heights = file.createVariable("depth", "i2", ("time", "y", "x"), fill_value=-32767)
        heights.set_auto_maskandscale(False)
        heights.scale_factor, heights.add_offset, heights.units, heights.positive = 0.5, 10.0, "m", "down"
        for time in range(2):
            other[time] = np.zeros((H, W))
            heights[time] = grid("int16") + time
    with netCDF4.Dataset(HERE / "other/cdf5.nc", "w", format="NETCDF3_64BIT_DATA") as file:
        file.createDimension("y", H)
        file.createDimension("x", W)
        file.createVariable("z", "u4", ("y", "x"))[:] = grid("uint32")
    with netCDF4.Dataset(HERE / "other/hdf.nc", "w", format="NETCDF4") as file:
        file.createDimension("y", H)
        file.createDimension("x", W)
        file.createVariable("z", "f4", ("y", "x"))[:] = grid("float32")


def pictures():
    Image.fromarray(grid("uint8")).save(HERE / "other/grey8.png")
    Image.fromarray(grid("uint16").astype("uint16")).save(HERE / "other/grey16.png")
    Image.fromarray(grid("uint8")).save(HERE / "other/grey.jpg", quality=95)
    Image.fromarray(grid("uint8")).convert("RGB").save(HERE / "other/grey.webp", lossless=True)
    heights = grid("float32").astype("float64")
    for name, raw in [("terrarium", np.round((heights + 32768.0) * 256.0)), ("mapbox", np.round((heights + 10000.0) * 10.0))]:
        raw = raw.astype("uint32")
        colours = np.stack([raw >> 16, raw >> 8 & 255, raw & 255], axis=-1).astype("uint8")
        Image.fromarray(colours, "RGB").save(HERE / f"other/{name}.png")
    for name, kind, compression in [("half", "float16", OpenEXR.ZIP_COMPRESSION), ("single", "float32", OpenEXR.PIZ_COMPRESSION),
                                    ("whole", "uint32", OpenEXR.NO_COMPRESSION)]:
        data = grid("float32").astype(kind) if kind != "uint32" else grid("uint32")
        header = {"compression": compression, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"Y": OpenEXR.Channel(data)}).write(str(HERE / f"other/{name}.exr"))
    two = {"other": OpenEXR.Channel(np.zeros((H, W), "float32")), "height": OpenEXR.Channel(grid("float32"))}
    OpenEXR.File({"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.scanlineimage}, two).write(str(HERE / "other/two.exr"))


def raws():
    square = 16
    grid("uint16", square, square).astype("<u2").tofile(HERE / "other/square.r16")
    grid("float32", square, square).astype("<f4").tofile(HERE / "other/square.r32")
    grid("int16").astype(">i2").tofile(HERE / "other/oblong.raw")


if __name__ == "__main__":
    for folder in ["tiff", "special", "other", "tmp"]:
        shutil.rmtree(HERE / folder, ignore_errors=True)
    (HERE / "other").mkdir()
    tiffs()
    rasters()
    netcdfs()
    pictures()
    raws()
    shutil.rmtree(HERE / "tmp")
    for leftover in HERE.glob("**/*.aux.xml"):
        leftover.unlink()
    files = [path for path in HERE.glob("**/*") if path.is_file()]
    print(len(files), "files,", sum(path.stat().st_size for path in files), "bytes")
