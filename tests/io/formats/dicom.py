# SPDX-License-Identifier: Apache-2.0
"""Series of DICOM (PS3.3 C.7.6), written by pydicom."""
import io

import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.pixel_data_handlers.rle_handler import rle_encode_frame
from pydicom.sequence import Sequence
from pydicom.uid import (DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian, ExplicitVRLittleEndian,
                         ImplicitVRLittleEndian, RLELossless)

from .cases import DIMS, Grid, case, damaged, image, rotation, volume

PIXEL = (0.5, 0.75)  # between columns, between rows
STEP = 2.0
ORIGIN = np.array([10.0, 20.0, 30.0])
CT, ENHANCED_CT, SECONDARY = '1.2.840.10008.5.1.4.1.1.2', '1.2.840.10008.5.1.4.1.1.2.1', '1.2.840.10008.5.1.4.1.1.7'
UNITS = ('mm',)
TYPES = ('uint8', 'int8', 'uint16', 'int16', 'uint32', 'int32')


def text(number) -> str:
    return f'{number:.10g}'


def written(samples, syntax=ExplicitVRLittleEndian, stored=None, preamble=True, **fields) -> bytes:
    """A file with the frames samples[x, y, z] (or one, samples[x, y]). `fields` replaces elements, None removes them."""
    frames = np.atleast_3d(samples).transpose(2, 1, 0)
    bits = samples.dtype.itemsize * 8
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = fields.get('SOPClassUID', CT)
    meta.MediaStorageSOPInstanceUID = '1.2.3.4'
    meta.TransferSyntaxUID = syntax
    data = FileDataset('', {}, file_meta=meta, preamble=b'\0' * 128 if preamble else None)
    data.is_little_endian = syntax != ExplicitVRBigEndian
    data.is_implicit_VR = syntax == ImplicitVRLittleEndian
    elements = dict(SOPClassUID=CT, SOPInstanceUID='1.2.3.4', Modality='CT', SeriesInstanceUID='1.2.3', StudyInstanceUID='1.2',
                    SeriesNumber=3, SeriesDescription='test', InstanceNumber=1, Rows=frames.shape[1], Columns=frames.shape[2],
                    SamplesPerPixel=1, PhotometricInterpretation='MONOCHROME2', BitsAllocated=bits, BitsStored=stored or bits,
                    HighBit=(stored or bits) - 1, PixelRepresentation=int(samples.dtype.kind == 'i'),
                    PixelSpacing=[text(PIXEL[1]), text(PIXEL[0])])
    if len(frames) > 1:
        elements['NumberOfFrames'] = len(frames)
    elements.update(fields)
    for name, value in elements.items():
        if value is not None:
            setattr(data, name, value)
    order = '<' if data.is_little_endian else '>'
    if syntax == RLELossless:
        data.PixelData = encapsulate([rle_encode_frame(f.astype('<' + f.dtype.str[1:])) for f in frames])
        data['PixelData'].is_undefined_length = True
    else:
        raw = frames.astype(frames.dtype.newbyteorder(order)).tobytes()
        data.PixelData = raw + b'\0' * (len(raw) % 2)
    data['PixelData'].VR = 'OB' if bits == 8 or syntax == RLELossless else 'OW'
    out = io.BytesIO()
    pydicom.dcmwrite(out, data, write_like_original=not preamble)
    return out.getvalue()


def place(z, direction=np.eye(3), step=STEP) -> dict:
    normal = np.cross(direction[:, 0], direction[:, 1])
    return dict(ImagePositionPatient=[text(v) for v in ORIGIN + step * z * normal],
                ImageOrientationPatient=[text(v) for v in direction[:, :2].T.ravel()])


def series(samples, direction=np.eye(3), heights=None, names='IM{}.dcm', shuffled=True, **how) -> dict:
    """A file per slice; names are not in the order of the slices."""
    n = samples.shape[2]
    order = np.random.default_rng(n).permutation(n) if shuffled else np.arange(n)
    each = how.pop('each', lambda z: {})
    return {names.format(order[z]): written(samples[:, :, z], **{**place(heights[z] if heights else z, direction),
                                                                 'InstanceNumber': int(order[z]) + 1, **how, **each(z)})
            for z in range(n)}


def right(samples, direction=np.eye(3), step=STEP, **more) -> Grid:
    normal = np.cross(direction[:, 0], direction[:, 1])
    return Grid(samples, **{'spacing': PIXEL + (step,), 'origin': tuple(ORIGIN), 'units': UNITS, 'space': ('LPS',),
                            'direction': np.column_stack([direction[:, 0], direction[:, 1], normal]), **more})


def kinds():
    found = []
    for kind in TYPES:
        samples = volume(kind)
        found.append(case(f'{kind}', series(samples), '.', right(samples), damage=kind == 'int16', by_program=True))
    samples = volume('int16')
    for syntax in (ImplicitVRLittleEndian, ExplicitVRBigEndian, DeflatedExplicitVRLittleEndian, RLELossless):
        found.append(case(f'int16, {syntax.name}', series(samples, syntax=syntax), '.', right(samples), by_program=True,
                          damage=syntax == RLELossless))
    found.append(case('uint8, RLE', series(volume('uint8'), syntax=RLELossless), '.', right(volume('uint8'))))
    for names in ('{}', 'IM{}', '1.2.840.{}', 'scan{}.IMA', 'x{}.DCM', 'y{}.dicom'):
        found.append(case(f'files {names}', series(samples, names=names), '.', right(samples)))
    found.append(case('without preamble', series(samples, preamble=False, syntax=ImplicitVRLittleEndian), '.', right(samples)))
    found.append(case('other files beside', {**series(samples), 'notes.txt': b'x', '.hidden.dcm': b'x', 'preview.png': b'x',
                                             'sub/IM9.dcm': b'x'}, '.', right(samples)))
    for degrees in (40.0, 90.0, 180.0):
        turned = rotation(degrees=degrees)
        found.append(case(f'turned by {degrees}', series(samples, turned), '.', right(samples, turned)))
    down = series(samples[:, :, ::-1], heights=[0, -1, -2])
    found.append(case('downwards', down, '.', right(samples, origin=tuple(ORIGIN - [0, 0, 2 * STEP]))))
    twelve = volume('int16', (5, 4, 12))
    found.append(case('twelve slices', series(twelve), '.', right(twelve)))
    unsigned = (volume('uint16') % 4096).astype('uint16')
    found.append(case('12 of 16 bits', series(unsigned, stored=12), '.', right(unsigned)))
    signed = (volume('int16') // 16).astype('int16')
    unclean = (signed & 0xfff).astype('int16')
    found.append(case('12 of 16 bits, signed', series(signed, stored=12), '.', right(signed)))
    found.append(case('12 of 16 bits, signed, the rest zero', series(unclean, stored=12), '.', right(signed)))
    return found


def rescaled():
    found = []
    unsigned = (volume('uint16') % 4096).astype('uint16')
    ct = (unsigned.astype(int) - 1024).astype('int16')
    found.append(case('intercept -1024 of 12 bits', series(unsigned, stored=12, RescaleSlope='1', RescaleIntercept='-1024'), '.',
                      right(ct), by_program=True))
    full = volume('uint16')
    found.append(case('intercept -1024 of 16 bits', series(full, RescaleSlope='1', RescaleIntercept='-1024'), '.',
                      right(full.astype('int32') - 1024)))
    small = volume('uint8')
    found.append(case('slope 2, intercept 0 of 8 bits', series(small, RescaleSlope='2', RescaleIntercept='0'), '.',
                      right(small.astype('uint16') * 2)))
    found.append(case('slope 0.1', series(full, RescaleSlope='0.1', RescaleIntercept='5'), '.',
                      right((full * 0.1 + 5).astype('float32'), any_type=True)))
    slopes = [0.5, 0.25, 2.0]
    values = np.stack([full[:, :, z] * slopes[z] for z in range(3)], axis=2).astype('float32')
    found.append(case('a slope for each slice', series(full, RescaleIntercept='0', each=lambda z: {'RescaleSlope': text(slopes[z])}),
                      '.', right(values)))
    found.append(case('slope 0', series(full, RescaleSlope='0', RescaleIntercept='0'), '.', right(full), refusable=True))
    return found


def refused():
    samples = volume('int16', (5, 4, 7))
    whole = series(samples, shuffled=False)
    found = [case('a slice is missing', {n: d for n, d in whole.items() if n != 'IM3.dcm'}, '.'),
             case('one but the last is missing', {n: d for n, d in whole.items() if n != 'IM5.dcm'}, '.'),
             case('the first is missing', {n: d for n, d in whole.items() if n != 'IM0.dcm'}, '.',
                  right(samples[:, :, 1:], origin=tuple(ORIGIN + [0, 0, STEP]))),
             case('a slice twice', {**whole, 'copy.dcm': whole['IM3.dcm']}, '.'),
             case('unequal distances', series(samples, heights=[0, 1, 2, 3, 4.5, 6, 7]), '.'),
             case('rounded distances', series(samples, heights=[0, 1.01, 2, 2.99, 4, 5.01, 6]), '.', right(samples)),
             case('two sizes', {**whole, 'IM3.dcm': written(samples[:4, :, 3], **place(3))}, '.'),
             case('two types', {**whole, 'IM3.dcm': written(samples[:, :, 3].astype('uint16'), **place(3))}, '.'),
             case('two sizes of pixels', series(samples, each=lambda z: {'PixelSpacing': ['1', '1']} if z == 2 else {}), '.'),
             case('two orientations', {**whole, 'x.dcm': written(samples[:, :, 3], **place(8, rotation()))}, '.'),
             case('two series', {**whole, 'x.dcm': written(samples[:, :, 3], SeriesInstanceUID='1.2.9', **place(9))}, '.'),
             case('a slice sideways', series(samples, each=lambda z: {'ImagePositionPatient': ['10.6', '20', '36']} if z == 3 else {}), '.'),
             case('tilted', series(samples, each=lambda z: {'ImagePositionPatient': ['10', text(20 + z * 0.6), text(30 + 2 * z)]}), '.'),
             case('axes that are not perpendicular', series(samples, ImageOrientationPatient=['1', '0', '0', '0.6', '0.8', '0']), '.'),
             case('axes of no length', series(samples, ImageOrientationPatient=['0', '0', '0', '0', '0', '0']), '.'),
             case('no size of pixels', series(samples, PixelSpacing=['0', '1']), '.'),
             case('a report', {'x.dcm': written(samples[:, :, 0], Rows=None, Columns=None)}, '.'),
             case('a damaged file beside', {**whole, 'IM9.dcm': b'hello' * 40}, '.'),
             case('no DICOM', b'hello' * 100, 'x.dcm'), case('empty', b'', 'x.dcm')]
    colours = np.repeat(samples[:, :, 0].astype('uint8'), 3, axis=1)
    found.append(case('colours', written(colours, Rows=4, SamplesPerPixel=3, PhotometricInterpretation='RGB', PlanarConfiguration=0),
                      'x.dcm'))
    for rows, columns in ((0, 5), (4, 0), (5, 5), (65535, 65535), (4, 65535)):
        found.append(case(f'header claims {columns} x {rows}', written(samples[:, :, 0], Rows=rows, Columns=columns, **place(0)), 'x.dcm'))
    for frames in (0, -1, 8, 10**6, 2**31 - 1):
        found.append(case(f'header claims {frames} frames', written(samples, NumberOfFrames=str(frames)), 'x.dcm', refusable=True))
    for bits in (0, 1, 12, 17, 24, 64):
        found.append(case(f'header claims {bits} bits', written(samples[:, :, 0], BitsAllocated=bits, **place(0)), 'x.dcm'))
    return found


def enhanced(samples, order, direction=np.eye(3), **more) -> bytes:
    """A multi-frame file with a place for each frame, the frames in `order`."""
    def item(**fields):
        data = Dataset()
        for name, value in fields.items():
            setattr(data, name, value)
        return data
    shared = item(PlaneOrientationSequence=Sequence([item(ImageOrientationPatient=place(0, direction)['ImageOrientationPatient'])]),
                  PixelMeasuresSequence=Sequence([item(PixelSpacing=[text(PIXEL[1]), text(PIXEL[0])], SliceThickness='9')]),
                  PixelValueTransformationSequence=Sequence([item(RescaleSlope='1', RescaleIntercept='-5')]))
    each = [item(PlanePositionSequence=Sequence([item(ImagePositionPatient=place(z, direction)['ImagePositionPatient'])])) for z in order]
    return written(samples[:, :, order], SOPClassUID=ENHANCED_CT, PixelSpacing=None, SharedFunctionalGroupsSequence=Sequence([shared]),
                   PerFrameFunctionalGroupsSequence=Sequence(each), **more)


def files():
    samples = (volume('int16', (5, 4, 6)) // 2).astype('int16')
    less = (samples.astype(int) - 5).astype('int32')
    found = []
    for syntax in (ExplicitVRLittleEndian, RLELossless):
        data = enhanced(samples, [3, 0, 5, 1, 2, 4], syntax=syntax)
        found.append(case(f'enhanced, {syntax.name}', data, 'x.dcm', right(less), by_program=True))
        found.append(case(f'enhanced in a folder, {syntax.name}', {'x.dcm': data}, '.', right(less)))
    turned = rotation()
    found.append(case('enhanced, turned', enhanced(samples, [3, 0, 5, 1, 2, 4], turned), 'x.dcm', right(less, turned)))
    found.append(case('enhanced, a frame missing', enhanced(samples, [3, 0, 5, 1, 2]), 'x.dcm', right(less[:, :, [0, 1, 2, 3, 5]], placed=False),
                      refusable=True))
    found[-1].right.clear()
    frames = written(samples, SpacingBetweenSlices='3')
    plain = Grid(samples, spacing=PIXEL + (3.0,), units=UNITS, space=('-',))
    found.append(case('frames without places', frames, 'x.dcm', plain))
    found.append(case('frames without sizes', written(samples, SOPClassUID=SECONDARY, PixelSpacing=None), 'x.dcm', Grid(samples, units=('-',))))
    flat = samples[:, :, 0]
    alone = image(flat, PIXEL, units=UNITS, space=('-',), origin=(10.0, 20.0, 0.0))
    found.append(case('one slice alone', written(flat, **place(0)), 'x.dcm', alone))
    found.append(case('one slice alone, a slab', written(flat, SliceThickness='4', **place(0)), 'x.dcm', right(flat.reshape(5, 4, 1), step=4.0),
                      how=(('dimension', '3'),)))
    whole = series(samples)
    name = sorted(whole)[2]
    found.append(case('one slice of a series', whole, name, right(samples), by_program=True))
    other = {f'b{n}': d for n, d in series(volume('int16'), SeriesInstanceUID='1.2.9').items()}
    found.append(case('one slice of one of two series', {**whole, **other}, name, right(samples)))
    found.append(case('one slice of the other', {**whole, **other}, sorted(other)[0], right(volume('int16'))))
    z = [z for z in range(6) if written(samples[:, :, z], **place(z), InstanceNumber=int(name[2]) + 1) == whole[name]][0]
    found.append(case('one slice of a series as an image', whole, name, image(samples[:, :, z], PIXEL, units=UNITS, space=('-',), origin=(10.0, 20.0, 0.0)),
                      how=(('dimension', '2'),)))
    bare = dict(ImagePositionPatient=None, ImageOrientationPatient=None, SliceThickness='3')
    found.append(case('without positions', series(samples, shuffled=False, **bare), '.', plain))
    found.append(case('without positions and numbers', series(samples, each=lambda z: {'InstanceNumber': None}, **bare), '.'))
    found.append(case('without positions, a number twice', series(samples, each=lambda z: {'InstanceNumber': 1}, **bare), '.'))
    return found


def cases():
    found = kinds() + rescaled() + refused() + files()
    bytes_ = series(volume('int16'), shuffled=False)
    for at in list(range(128, len(bytes_['IM1.dcm']), 5)):
        changed = bytearray(bytes_['IM1.dcm'])
        changed[at] ^= 0x24
        found.append(case(f'byte {at} changed', {**bytes_, 'IM1.dcm': bytes(changed)}, '.', Grid(volume('int16'), anything=True),
                          refusable=True))
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
