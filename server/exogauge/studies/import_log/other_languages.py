"""Words of column names in other languages than English, and what they are in it."""

from __future__ import annotations

import re
from functools import cache

ENGLISH = {
    "time": "zeit tiempo tempo",
    "stamp": "stempel zeitstempel",
    "angle": "winkel ángulo angulo angolo",
    "position": "lage stellung posición posicion posizione posição posicao",
    "velocity": "geschwindigkeit drehzahl winkelgeschwindigkeit vitesse velocidad velocità velocita velocidade",
    "acceleration": "beschleunigung accélération aceleración aceleracion accelerazione aceleração",
    "gyro": "drehrate",
    "torque": "drehmoment moment couple coppia",
    "current": "strom courant corriente corrente",
    "command": "soll sollwert consigne consigna desejada deseada deseado desiderata desiderato",
    "temperature": "temperatur température temperatura",
    "force": "kraft fuerza forza força",
    "axis": "achse achs achsen axe axes eje asse",
    "joint": "gelenk gelenke articulation articulación articulacion giunto junta",
    "measured": "gemessen gemessene gemessener mesure mesuré mesurée medida medido misurata misurato",
    "actual": "ist istwert",
    "value": "wert messwert",
}
WITHOUT_SPACES = {
    "time": "時間 時刻 时间 时间戳 시간",
    "angle": "角度 位置 関節角 关节角 關節角 각도 위치",
    "velocity": "速度 角速度 속도 각속도",
    "acceleration": "加速度 가속도",
    "qacc": "角加速度",
    "gyro": "ジャイロ 陀螺仪",
    "torque": "トルク 力矩 扭矩 转矩 토크",
    "current": "電流 电流 전류",
    "command": "指令 目標 目标 期望 设定 명령 지령 목표",
    "temperature": "温度 온도",
    "joint": "関節 关节 軸 轴 關節 관절 축",
    "motor": "モータ モーター 电机 馬達 모터",
    "measured": "実測 計測 測定 测量 实际 測量 측정",
    "value": "値 值 값",
}  # of scripts that set no space between words, or often none
_OF = {word: english for english, words in ENGLISH.items() for word in words.split()}
_PIECE = {word: english for english, words in WITHOUT_SPACES.items() for word in words.split()}
_PIECES = re.compile("|".join(sorted(_PIECE, key=len, reverse=True)))
_SHORTEST = 3  # letters of a part of a compound: fewer stand in many a word


def spaced(name: str) -> str:
    """A name with the words of scripts without spaces replaced, and set apart."""
    return _PIECES.sub(lambda found: f" {_PIECE[found.group()]} ", name)


@cache
def in_english(token: str, known: frozenset[str]) -> tuple[str, ...]:
    """A word of small letters, or the two that it is made of: `sollposition`. known: English words that a compound may
    have as its other part. The word itself where it is none of these."""
    if token in _OF:
        return (_OF[token],)
    words = {**{word: word for word in known if len(word) >= _SHORTEST}, **_OF}
    for end in range(_SHORTEST, len(token) - _SHORTEST + 1):
        first, second = token[:end], token[end:]
        if first in words and second in words and (first in _OF or second in _OF):
            return words[first], words[second]
    return (token,)
