// Writes the licences of the project into one file, as a packed extension has it.
"use strict";

const fs = require("node:fs");
const path = require("node:path");

const root = path.resolve(__dirname, "../../..");
const texts = ["LICENSE-MIT", "LICENSE-APACHE"].map((name) => fs.readFileSync(path.join(root, name), "utf8").trim());
fs.writeFileSync(path.join(__dirname, "LICENSE.txt"), `MIT OR Apache-2.0\n\n${texts.join("\n\n\n")}\n`);
