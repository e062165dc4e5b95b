"""Check the example for Kubernetes against the schemas of its interfaces (`./run release`)."""

from pathlib import Path

import kubernetes_validate
import yaml

FOLDER = Path(__file__).resolve().parent / "kubernetes"
KUBERNETES = "1.37"
OTHERS = ("keda.sh/",)  # kinds that Kubernetes itself does not know

for path in sorted(FOLDER.glob("*.yaml")):
    for document in yaml.safe_load_all(path.read_text("utf-8")):
        if not document["apiVersion"].startswith(OTHERS):
            kubernetes_validate.validate(document, KUBERNETES, strict=True)
            print(f"{document['kind']} {document['metadata']['name']} has its schema")
