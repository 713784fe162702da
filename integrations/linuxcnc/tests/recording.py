"""Stores the result of a run: columns of doubles, one row per servo cycle."""
import array
import json


class Recording:
    """Columns by the name of their HAL pin, with every value exactly as the pin had it."""

    def __init__(self, names, rows):
        self.names = list(names)
        self.rows = rows
        self.place = {name: i for i, name in enumerate(self.names)}

    def column(self, name):
        i = self.place[name]
        return [row[i] for row in self.rows]

    def columns(self, *names):
        return list(zip(*(self.column(name) for name in names)))

    def cut(self, start, stop=None):
        return Recording(self.names, self.rows[start:stop])

    def save(self, path):
        """Saves `path`.json, the names, and `path`.f64, rows of little-endian doubles."""
        with open(path + ".json", "w") as f:
            json.dump({"columns": self.names, "rows": len(self.rows)}, f)
        with open(path + ".f64", "wb") as f:
            flat = array.array("d")
            for row in self.rows:
                flat.extend(float(value) for value in row)
            flat.tofile(f)

    @staticmethod
    def load(path):
        with open(path + ".json") as f:
            head = json.load(f)
        width = len(head["columns"])
        flat = array.array("d")
        with open(path + ".f64", "rb") as f:
            flat.fromfile(f, head["rows"] * width)
        return Recording(head["columns"], [flat[i : i + width] for i in range(0, len(flat), width)])
